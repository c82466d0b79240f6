#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace planar::test {

/// The eight bytes that open a control transfer.
struct UsbSetup {
  std::uint8_t request_type{0};
  std::uint8_t request{0};
  std::uint16_t value{0};
  std::uint16_t index{0};
  std::uint16_t length{0};

  bool to_host() const { return (request_type & 0x80) != 0; }
};

/// How a transfer ended: 0 or a negative errno as usbfs reports it (-EPIPE is a stall), and the
/// bytes moved.
struct UsbOutcome {
  int status{0};
  std::size_t bytes{0};
};

/// What a device does with what reaches it. Called by the bus' own thread, one transfer at a time.
class UsbFunction {
 public:
  virtual ~UsbFunction() = default;

  /// A control transfer that is not about standard descriptors. `data` has setup.length bytes, to
  /// be filled (to the host) or read.
  virtual UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) = 0;
  virtual UsbOutcome bulk_out(int endpoint, const std::uint8_t* data, std::size_t size);
  /// Empty while there is nothing to send: the transfer stays pending and is asked for again about
  /// every millisecond.
  virtual std::optional<UsbOutcome> bulk_in(int endpoint, std::uint8_t* data, std::size_t size);
};

/// What is wrong with the next control transfers.
struct UsbFault {
  enum class Kind { kStall, kIoError, kSilence, kShort, kLate };
  Kind kind{Kind::kStall};
  int count{1};                           ///< transfers that suffer it; -1: all, until cleared
  std::optional<std::uint8_t> request{};  ///< only this request; any when empty
  double late_s{0.0};    ///< of kLate: the function acts at once, the host hears late
  std::size_t bytes{0};  ///< of kShort: what still arrives
};

struct UsbDescription {
  std::vector<std::uint8_t> device_descriptor;         ///< 18 bytes
  std::vector<std::uint8_t> configuration_descriptor;  ///< with all that belongs to it
  std::vector<std::string> strings;                    ///< number 1, 2, ...
  int speed_mbit{12};
};

/// A USB bus below libusb, made by umockdev: whatever is plugged into it, unmodified programs find,
/// open and talk to through the real libusb. They must run with umockdev's library preloaded
/// (umockdev-wrapper), this process as well if it is to see the bus itself. One at a time.
class MockUsbBus {
 public:
  MockUsbBus();
  ~MockUsbBus();
  MockUsbBus(const MockUsbBus&) = delete;
  MockUsbBus& operator=(const MockUsbBus&) = delete;

  /// False unless this process itself runs under umockdev-wrapper.
  bool seen_by_this_process() const;

 private:
  friend class MockUsbDevice;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One device of the bus, plugged in from the start. Safe to use from any thread.
class MockUsbDevice {
 public:
  /// Bus and function must outlive the device. Throws std::runtime_error when umockdev refuses it.
  MockUsbDevice(MockUsbBus& bus, UsbDescription description, UsbFunction& function);
  ~MockUsbDevice();
  MockUsbDevice(const MockUsbDevice&) = delete;
  MockUsbDevice& operator=(const MockUsbDevice&) = delete;

  /// As when the cable is pulled: pending transfers fail, the device leaves the bus.
  void unplug();
  /// Plugs it in again, at a new address.
  void plug();

  void inject(const UsbFault& fault);
  void clear_fault();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar::test
