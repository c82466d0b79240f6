#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "support/mock_usb.h"

namespace {

constexpr int kSkipped = 77;  // planar_wire_test() tells ctest the same number

/// Skips a test program where devices cannot be emulated below libusb.
struct WireGuard final : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testRunStarting(const Catch::TestRunInfo& /*info*/) override {
    if (planar::test::MockUsbBus().seen_by_this_process()) return;
    std::puts("skipped: umockdev's library is not preloaded; run this under umockdev-wrapper");
    std::exit(kSkipped);
  }
};

CATCH_REGISTER_LISTENER(WireGuard)

}  // namespace
