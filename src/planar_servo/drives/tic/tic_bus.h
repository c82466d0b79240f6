#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/drives/tic/tic_protocol.h"

struct libusb_context;
struct libusb_device_handle;

namespace planar {

/// Describes a Tic that is plugged in.
struct TicListing {
  std::string serial;
  std::uint16_t product_id{0};
  std::uint16_t firmware{0};  ///< binary coded decimal
  std::string device;         ///< "/dev/bus/usb/001/004"
};

/// An opened Tic. No other process can use it until it is closed.
class TicPort {
 public:
  ~TicPort();
  TicPort(const TicPort&) = delete;
  TicPort& operator=(const TicPort&) = delete;

  const TicListing& listing() const { return listing_; }

 private:
  friend class TicBus;
  TicPort(libusb_device_handle* handle, TicListing listing)
      : handle_(handle), listing_(std::move(listing)) {}

  libusb_device_handle* handle_;
  TicListing listing_;
};

/// One control transfer and its outcome.
struct TicTransfer {
  TicPort* port{nullptr};  ///< if null, nothing is transferred
  tic::Command command{tic::Command::kResetCommandTimeout};
  std::uint16_t value{0};
  std::uint16_t index{0};
  std::vector<std::uint8_t> data{};  ///< sized to the bytes that are to be read
  std::string error{};               ///< in words; empty on success
  bool lost{false};                  ///< whether the device has left the bus
};

/// Gives access to the Tics on the USB bus. After construction nothing here throws but bad_alloc.
class TicBus {
 public:
  /// Throws WorkError when this machine has no USB.
  TicBus();
  ~TicBus();
  TicBus(const TicBus&) = delete;
  TicBus& operator=(const TicBus&) = delete;

  /// Opens the Tic with this serial number. Returns nothing when that fails; `why` then says what
  /// is wrong.
  std::unique_ptr<TicPort> open(const std::string& serial, Refusal& why);

  /// Runs all transfers and waits until each has ended or has taken longer than the timeout.
  /// Transfers to one device run in their order, those to different devices at the same time.
  void exchange(std::vector<TicTransfer>& transfers, double timeout_s);

 private:
  libusb_context* context_{nullptr};
};

}  // namespace planar
