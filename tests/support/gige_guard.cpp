#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "planar_servo/base/core/error.h"
#include "planar_servo/machine/rehearsal/gige_camera.h"

namespace {

constexpr int kSkipped = 77;  // planar_gige_test() tells ctest the same number

/// Skips a test program where no camera can be served on loopback.
struct GigeGuard final : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testRunStarting(const Catch::TestRunInfo& /*info*/) override {
    try {
      const planar::GigeCamera camera("127.0.0.1", "guard", {64, 64}, 10.0, {});
    } catch (const planar::WorkError& error) {
      std::printf("skipped: %s\n", error.what());
      std::exit(kSkipped);
    }
  }
};

CATCH_REGISTER_LISTENER(GigeGuard)

}  // namespace
