#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "servo/servo_bench.h"

namespace planar {
namespace {

/// The landings of an arm that is known to 10 um, but may stray by 2 mm.
class StrayingLandings final : public LandingModel {
 public:
  LandingPrior at(const Joints& /*theta_c*/, const TipMeasurement& /*look*/) const override {
    LandingPrior prior;
    prior.covariance = 1e-10 * Eigen::Matrix4d::Identity();
    prior.scatter_m = prior.short_scatter_m = 5e-6;
    prior.stray_m = 2e-3;
    return prior;
  }
  void learn(const SeenLanding& seen) override { stays_off_ = seen.stays_off; }
  std::optional<Doubt> doubt() const override {
    if (!stays_off_) return std::nullopt;
    return Doubt{{"it stays off"}};
  }

 private:
  bool stays_off_{false};
};

test::MachineKind well_known_machine() {
  test::MachineKind kind;
  kind.as_its_data_sheet = true;
  kind.scatter_m = 2e-6;
  return kind;
}

/// A machine whose end point is seen off by so much, once or as long as somebody looks.
struct StrayingBench : test::ServoBench {
  StrayingBench() : ServoBench(well_known_machine()) { limits.distance_m = 4e-3; }

  ServoResult move_off_by(double off_m, bool once) {
    PositionServo servo(settings, limits, planner, robot, sensor, cell.clock(), &landings);
    sensor.offset_m.x() = off_m;
    return servo.move_to(test::kTarget, [&](const ServoStep& /*step*/) {
      moves = cell.targets_sent();
      if (once) sensor.offset_m.setZero();
    });
  }

  StrayingLandings landings;
  std::size_t moves{0};
};

}  // namespace

TEST_CASE("An arm that has strayed comes again and reaches its target") {
  for (const double off_m : {0.2e-3, 1e-3, 2e-3, 6e-3}) {
    StrayingBench bench;
    const ServoResult result = bench.move_off_by(off_m, true);
    INFO(off_m);
    CHECK(result.status == ServoStatus::kReached);
    CHECK(bench.true_distance(test::kTarget) < 20e-6);
  }
}

TEST_CASE("An arm that misses by more than the guard allows comes again once") {
  StrayingBench bench;
  const ServoResult result = bench.move_off_by(6e-3, false);
  CHECK(result.status == ServoStatus::kHeld);
  CHECK(result.cell_in_doubt);
  CHECK(result.steps.size() == 2);
  CHECK(bench.cell.targets_sent() == bench.moves);
  StrayingBench farther;
  CHECK(farther.move_off_by(12e-3, true).steps.size() == 1);
}

TEST_CASE("An arm that is as far off when it comes again is held, and moves no more") {
  StrayingBench bench;
  const ServoResult result = bench.move_off_by(1e-3, false);
  CHECK(result.status == ServoStatus::kHeld);
  CHECK(result.reason == "it stays off");
  CHECK_FALSE(result.cell_in_doubt);
  CHECK(result.steps.size() == 2);
  CHECK(bench.cell.targets_sent() == bench.moves);
}

}  // namespace planar
