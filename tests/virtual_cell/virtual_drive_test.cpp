#include "planar_servo/virtual_cell/virtual_drive.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kScale = 1e5;  // pulses per radian
constexpr double kRoundOff = 1e-12;
const VirtualDrive::Settings kSettings{kScale, {20000.0, 100000.0}, 0};

struct DriveBench {
  explicit DriveBench(const ReducerTruth& reducer = {}) : drive(clock, kSettings, reducer) {
    drive.energize();
  }
  void go(std::int32_t target) {
    drive.set_target(target);
    clock.sleep_for_s(60.0);
  }
  VirtualClock clock;
  VirtualDrive drive;
};

}  // namespace

TEST_CASE("VirtualDrive moves for the time of the trapezoid and reports itself moving") {
  DriveBench bench;
  bench.drive.set_target(40000);
  CHECK(bench.drive.status().moving);
  bench.clock.sleep_for_s(1.1);  // half of 40000 / 20000 + 20000 / 100000
  CHECK(bench.drive.status().position_pulses == 20000);
  bench.clock.sleep_for_s(1.101);
  CHECK_FALSE(bench.drive.status().moving);
  CHECK(bench.drive.status().position_pulses == 40000);
  CHECK(bench.drive.output_rad() == Approx(0.4));
}

TEST_CASE("VirtualDrive keeps to lower limits but not to limits beyond its rating") {
  DriveBench slow;
  slow.drive.set_limits({10000.0, 50000.0});
  slow.drive.set_target(20000);
  slow.clock.sleep_for_s(1.1);  // half of 20000 / 10000 + 10000 / 50000
  CHECK(slow.drive.status().position_pulses == 10000);
  DriveBench fast;
  fast.drive.set_limits({1e9, 1e9});
  fast.drive.set_target(40000);
  fast.clock.sleep_for_s(1.1);
  CHECK(fast.drive.status().position_pulses == 20000);
  CHECK_THROWS_AS(slow.drive.set_limits({0.0, 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(slow.drive.set_limits({1.0, std::numeric_limits<double>::quiet_NaN()}),
                  std::invalid_argument);
}

TEST_CASE("VirtualDrive refuses targets while de-energized") {
  VirtualClock clock;
  VirtualDrive drive(clock, kSettings, {});
  CHECK_THROWS_MATCHES(drive.set_target(1), WorkError, Refused(Cause::kDevice));
  CHECK_THROWS_AS(drive.set_target(1), WorkError);
  drive.energize();
  CHECK_NOTHROW(drive.set_target(1));
}

TEST_CASE("VirtualDrive halts where it is and then doubts its position") {
  DriveBench bench;
  bench.drive.halt();
  CHECK(bench.drive.status().position_certain);
  bench.drive.set_target(40000);
  bench.clock.sleep_for_s(1.1);
  bench.drive.halt();
  bench.clock.sleep_for_s(5.0);
  const DriveStatus status = bench.drive.status();
  CHECK(status.position_pulses == 20000);
  CHECK(status.target_pulses == 20000);
  CHECK_FALSE(status.moving);
  CHECK_FALSE(status.position_certain);
}

TEST_CASE("VirtualDrive is sure of its position again once it has found its switch") {
  DriveBench bench;
  bench.drive.set_target(40000);
  bench.clock.sleep_for_s(1.1);
  bench.drive.halt();
  bench.drive.start_homing(HomeDirection::kReverse);
  CHECK(bench.drive.status().homing);
  CHECK_FALSE(bench.drive.status().position_certain);
  bench.clock.sleep_for_s(60.0);
  CHECK_FALSE(bench.drive.status().homing);
  CHECK(bench.drive.status().position_certain);
  CHECK(bench.drive.status().position_pulses == 0);
  CHECK(bench.drive.output_rad() == Approx(0.0).margin(kRoundOff));
}

TEST_CASE("VirtualDrive counts from the position that it is told, without turning") {
  DriveBench bench;
  bench.go(1000);
  const double before = bench.drive.output_rad();
  bench.drive.set_position(-500);
  CHECK(bench.drive.status().position_pulses == -500);
  CHECK(bench.drive.output_rad() == before);
  bench.go(500);
  CHECK(bench.drive.output_rad() - before == Approx(0.01));
  bench.drive.set_target(0);
  CHECK_THROWS_AS(bench.drive.set_position(0), WorkError);
}

TEST_CASE("Backlash parts the two directions of approach by its whole width") {
  ReducerTruth reducer;
  reducer.backlash_rad = 2e-4;  // 20 pulses
  DriveBench bench(reducer);
  bench.go(1000);
  const double upwards = bench.drive.output_rad();
  bench.go(1500);
  bench.go(1000);
  CHECK(upwards == Approx(0.01 - 1e-4).margin(kRoundOff));
  CHECK(bench.drive.output_rad() - upwards == Approx(2e-4).margin(kRoundOff));
}

TEST_CASE("A turn within the backlash moves nothing") {
  ReducerTruth reducer;
  reducer.backlash_rad = 2e-4;
  DriveBench bench(reducer);
  bench.go(1000);
  const double before = bench.drive.output_rad();
  bench.go(985);
  CHECK(bench.drive.output_rad() == before);
  bench.go(975);
  CHECK(bench.drive.output_rad() == Approx(before - 5.0 / kScale).margin(kRoundOff));
}

TEST_CASE("Backlash remembers how far the motor ran on before a late reversal") {
  ReducerTruth reducer;
  reducer.backlash_rad = 2e-4;
  DriveBench bench(reducer);
  bench.drive.set_target(40000);
  bench.clock.sleep_for_s(1.1);
  bench.go(20000);  // braking from full speed carries the motor 2000 pulses beyond
  CHECK(bench.drive.output_rad() == Approx(0.2 + 1e-4).margin(kRoundOff));
}

TEST_CASE("Eccentric wheels add their harmonics of the motor's angle and the zero offset") {
  ReducerTruth reducer;
  reducer.zero_offset_rad = 0.002;
  reducer.eccentricity = {{5e-4, 0.3, 1}, {1e-4, -1.0, 2}};
  DriveBench bench(reducer);
  for (const std::int32_t target : {0, 70000, 250000, -120000}) {
    bench.go(target);
    const double m = target / kScale;
    CHECK(bench.drive.output_rad() ==
          Approx(m + 0.002 + 5e-4 * std::sin(m + 0.3) + 1e-4 * std::sin(2.0 * m - 1.0))
              .margin(kRoundOff));
  }
}

TEST_CASE("VirtualClock refuses to run backwards") {
  VirtualClock clock;
  CHECK_THROWS_AS(clock.sleep_for_s(-1e-9), std::invalid_argument);
  CHECK_THROWS_AS(clock.sleep_for_s(std::numeric_limits<double>::quiet_NaN()),
                  std::invalid_argument);
}

}  // namespace planar
