#include "support/usb_function.h"

#include <cerrno>

namespace planar::test {

UsbOutcome UsbFunction::bulk_out(int /*endpoint*/, const std::uint8_t* /*data*/,
                                 std::size_t /*size*/) {
  return {-EPIPE, 0};
}

std::optional<UsbOutcome> UsbFunction::bulk_in(int /*endpoint*/, std::uint8_t* /*data*/,
                                               std::size_t /*size*/) {
  return UsbOutcome{-EPIPE, 0};
}

}  // namespace planar::test
