#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/drives/tic/tic_protocol.h"

struct libusb_context;
struct libusb_device_handle;

namespace planar {

/// A Tic that is plugged in.
struct TicListing {
  std::string serial;  ///< empty when it cannot be asked
  std::uint16_t product_id{0};
  std::uint16_t firmware{0};  ///< binary coded decimal
  std::string device;         ///< "/dev/bus/usb/001/004"
  std::string refusal;        ///< why it cannot be opened, in words; empty when it can
};

/// An opened Tic, nobody else's until it is closed.
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

/// One control transfer with its outcome.
struct TicTransfer {
  TicPort* port{nullptr};  ///< without one nothing is transferred
  tic::Command command{tic::Command::kResetCommandTimeout};
  std::uint16_t value{0};
  std::uint16_t index{0};
  std::vector<std::uint8_t> data{};  ///< as many bytes as are to be read
  std::string error{};               ///< in words; empty when all went well
  bool lost{false};                  ///< the device has left the bus
};

/// The USB bus with its Tics. Nothing here throws once the bus is made, but for bad_alloc.
class TicBus {
 public:
  /// Throws WorkError when there is no USB here.
  TicBus();
  ~TicBus();
  TicBus(const TicBus&) = delete;
  TicBus& operator=(const TicBus&) = delete;

  std::vector<TicListing> list();

  /// Empty when it is absent or refuses; `why` says then what is the matter and how to mend it.
  std::unique_ptr<TicPort> open(const std::string& serial, std::string& why);

  /// Does all transfers at the same time and returns when each has ended, which none may take
  /// longer for than the timeout. Those to one device are done in their order.
  void exchange(std::vector<TicTransfer>& transfers, double timeout_s);

 private:
  libusb_context* context_{nullptr};
};

}  // namespace planar
