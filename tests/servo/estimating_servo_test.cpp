#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "servo/servo_bench.h"

namespace planar {
namespace {

/// A servo that estimates landings and keeps what it learned from target to target.
struct EstimatingBench : test::ServoBench {
  explicit EstimatingBench(const test::MachineKind& kind = {}) : ServoBench(kind) {}

  PositionServo servo() {
    return {settings, limits, planner, robot, sensor, cell.clock(), &landings};
  }
  UnknownLandings landings{limits.distance_m};
};

test::MachineKind scattering(double scatter_m) {
  test::MachineKind kind;
  kind.scatter_m = scatter_m;
  return kind;
}

}  // namespace

TEST_CASE("Estimating landings, the servo reaches its targets as soon as by the last look") {
  EstimatingBench bench;
  PositionServo servo = bench.servo();
  for (int i = 0; i < 12; ++i) {
    const ServoResult result = servo.move_to(test::on_circle(i));
    CHECK(result.status == ServoStatus::kReached);
    CHECK(result.iterations <= 2);
    CHECK(bench.true_distance(test::on_circle(i)) < bench.settings.tolerance_m);
  }
}

TEST_CASE("An arm that scatters is positioned, and its cell is never in doubt") {
  for (const double scatter_m : {10e-6, 40e-6}) {
    EstimatingBench bench(scattering(scatter_m));
    bench.settings.tolerance_m = 1.5 * scatter_m;
    PositionServo servo = bench.servo();
    int reached = 0;
    for (int i = 0; i < 100; ++i) {
      const ServoResult result = servo.move_to(test::on_circle(i));
      CHECK_FALSE(result.cell_in_doubt);
      if (result.status == ServoStatus::kReached) ++reached;
    }
    CHECK(reached >= 95);
  }
}

TEST_CASE("Without a model of landings the same scatter puts the cell in doubt") {
  test::ServoBench bench(scattering(10e-6));
  bool in_doubt = false;
  for (int i = 0; i < 100; ++i) in_doubt |= bench.move_to(test::on_circle(i)).cell_in_doubt;
  CHECK(in_doubt);
}

TEST_CASE("Without a model each step is the law's for the whole error of the last look") {
  test::ServoBench bench(scattering(10e-6));
  for (int i = 0; i < 12; ++i) {
    const std::vector<ServoStep> steps = bench.move_to(test::on_circle(i)).steps;
    for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
      const TipMeasurement& seen = steps[k].measurement;
      const LawStep law = jacobian_law(bench.planner.arm(),
                                       {steps[k].theta_c, seen.tip.p, seen.tip.p + steps[k].error},
                                       bench.settings.gain);
      Joints theta = steps[k].theta_c;
      theta.head<2>() += law.delta_theta;
      theta[2] += steps[k].turn_error;
      CHECK(steps[k + 1].pulses_c == bench.planner.transmission().pulses_from_joints(theta));
    }
    CHECK_FALSE(steps.back().estimate);
  }
}

TEST_CASE("A tolerance far below the scatter ends early and says why") {
  EstimatingBench bench(scattering(30e-6));
  bench.settings.tolerance_m = 2e-6;
  PositionServo servo = bench.servo();
  for (int i = 0; i < 20; ++i) servo.move_to(test::on_circle(i));
  int corrections = 0;
  for (int i = 0; i < 40; ++i) {
    const ServoResult result = servo.move_to(test::on_circle(i));
    corrections += result.iterations;
    if (result.status == ServoStatus::kReached) continue;
    REQUIRE(result.status == ServoStatus::kNotConverged);
    if (result.iterations < bench.settings.max_iterations)
      CHECK_THAT(result.reason, Catch::Contains("stops scatter by 0.0") &&
                                    Catch::Contains("the tolerance 0.002") &&
                                    Catch::Contains("not expected to end nearer"));
  }
  CHECK(corrections < 40 * 8);
}

TEST_CASE("Looks that contradict each other halt the arm and put the cell in doubt") {
  test::MachineKind exact;
  exact.as_its_data_sheet = true;
  EstimatingBench bench(exact);
  bench.settings.approach = Approach::kOneSide;
  bench.sensor.offset_m.x() = 45e-6;
  PositionServo servo = bench.servo();
  for (int i = 0; i < 24; ++i) CHECK_FALSE(servo.move_to(test::on_circle(i)).cell_in_doubt);
  const ServoResult result = servo.move_to(
      test::kTarget, [&](const ServoStep& /*step*/) { bench.sensor.offset_m.x() = -45e-6; });
  CHECK(result.status == ServoStatus::kDiverged);
  CHECK(result.cell_in_doubt);
  REQUIRE(result.steps.back().estimate);
  CHECK(result.steps.back().estimate->is_contradicted);
  for (int i = 0; i < 3; ++i) CHECK(bench.cell.drive(i).halts == 1);
}

TEST_CASE("Play on a direct approach neither puts the cell in doubt nor keeps it from targets") {
  test::MachineKind worn;
  worn.play_rad = 0.05 * kDegree;
  EstimatingBench bench(worn);
  PositionServo servo = bench.servo();
  for (int i = 0; i < 24; ++i) {
    const ServoResult result = servo.move_to(test::on_circle(i));
    CHECK(result.status == ServoStatus::kReached);
    CHECK(result.iterations <= 3);
  }
}

TEST_CASE("A gain below 1 makes that share of the correction that the estimate asks for") {
  EstimatingBench bench;
  bench.settings.gain = 0.5;
  const ServoResult result = bench.servo().move_to(test::kTarget);
  CHECK(result.status == ServoStatus::kReached);
  REQUIRE(result.steps.size() >= 2);
  const double left = result.steps[1].error.norm() / result.steps[0].error.norm();
  CHECK(left == Approx(0.5).margin(0.03));
}

TEST_CASE("A step says where the end point is believed to be and how certain that is") {
  EstimatingBench bench;
  bench.sensor.frame_noise_m = 6e-6;
  bench.settings.frames_per_measurement = 9;
  const ServoResult result = bench.servo().move_to(test::kTarget);
  REQUIRE(result.steps.back().estimate);
  const ServoStep& last = result.steps.back();
  CHECK(last.uncertainty_m() <= 2e-6 * 1.01);
  CHECK(last.uncertainty_m() > 0.5e-6);
  CHECK((last.believed_p() - bench.cell.true_tip().p).norm() < 1e-6);
  CHECK(last.miss_m() < last.stop_below_m);
}

TEST_CASE("A look that is doubted has no estimate and teaches nothing") {
  EstimatingBench bench;
  bench.sensor.offset_m = {50e-3, 0.0};
  const ServoResult result = bench.servo().move_to(test::kTarget);
  CHECK(result.status == ServoStatus::kHeld);
  CHECK_FALSE(result.steps.back().estimate);
}

}  // namespace planar
