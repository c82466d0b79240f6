#pragma once

#include <cstddef>
#include <cstdint>
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

  /// Returns true for a transfer from the device to the host.
  bool to_host() const { return (request_type & 0x80) != 0; }
};

/// How a transfer ended: 0 or a negative errno as usbfs reports it (-EPIPE is a stall), and the
/// bytes moved.
struct UsbOutcome {
  int status{0};
  std::size_t bytes{0};
};

/// Says what a device does with what reaches it. The bus' own thread calls it, one transfer at a
/// time.
class UsbFunction {
 public:
  virtual ~UsbFunction() = default;

  /// Serves a control transfer that is not about standard descriptors. `data` has setup.length
  /// bytes, which are filled (to the host) or read.
  virtual UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) = 0;
  /// Serves a bulk transfer from the host. A device without bulk endpoints stalls.
  virtual UsbOutcome bulk_out(int endpoint, const std::uint8_t* data, std::size_t size);
  /// Serves a bulk transfer to the host. While it returns nothing, the transfer stays pending and
  /// is asked for again about every millisecond.
  virtual std::optional<UsbOutcome> bulk_in(int endpoint, std::uint8_t* data, std::size_t size);
};

/// Holds the descriptors of a device.
struct UsbDescription {
  std::vector<std::uint8_t> device_descriptor;         ///< 18 bytes
  std::vector<std::uint8_t> configuration_descriptor;  ///< includes all that belongs to it
  std::vector<std::string> strings;                    ///< strings number 1, 2, ...
  int speed_mbit{12};
};

}  // namespace planar::test
