#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "servo/servo_bench.h"

namespace planar {
namespace {

/// An arm that is known to be its data sheet's to 0.1 mm of its links and 0.01 degrees of its
/// zeros.
FoundArm arm_by_data_sheet(const JointPlanner& planner) {
  FoundArm arm;
  arm.x = Eigen::VectorXd::Zero(7);
  arm.x.head<2>().setConstant(0.3);
  arm.factor = Eigen::MatrixXd::Zero(7, 5);
  arm.factor.topLeftCorner<2, 2>().diagonal().setConstant(0.1e-3);
  arm.factor.block<3, 3>(2, 2).diagonal().setConstant(0.01 * kDegree);
  arm.scatter_m = 10e-6;
  JointPlanner told = planner;
  told.plan_for(arm);
  return *told.found();
}

/// Learns the arm by a vision that is never wrong.
class LearnedLandings final : public LandingModel {
 public:
  LearnedLandings(const FoundArm& found, const Transmission& transmission, bool plans)
      : learner_(found, not_yet_learned(found, {})), transmission_(transmission), plans_(plans) {}

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override {
    LandingPrior prior;
    prior.covariance = learner_.landing_covariance(transmission_.motors_from_joints(theta_c),
                                                   Eigen::Matrix2Xd::Zero(2, 5), look.t_s);
    prior.scatter_m = prior.short_scatter_m = 10e-6;
    return prior;
  }
  void learn(const SeenLanding& seen) override {
    if (!seen.is_first || seen.has_strayed) return;
    learner_.take({transmission_.motors_from_joints(seen.theta_c), seen.look.tip.p,
                   Eigen::Matrix2Xd::Zero(2, 5), seen.scatter_m},
                  seen.look.t_s);
  }
  const FoundArm* learned_arm() const override {
    return plans_ ? &learner_.learned().arm : nullptr;
  }

 private:
  ArmLearner learner_;
  Transmission transmission_;
  bool plans_;
};

struct LearningBench : test::ServoBench {
  explicit LearningBench(const test::MachineKind& kind) : ServoBench(kind) {
    settings.tolerance_m = 30e-6;
    planner.plan_for(arm_by_data_sheet(planner));
  }

  /// Moves to the places of a circle again and again. Returns how far the first landings at the
  /// last twelve missed, on average, metres.
  double first_miss_m(bool plans) {
    LearnedLandings landings(*planner.found(), planner.transmission(), plans);
    PositionServo servo(settings, limits, planner, robot, sensor, cell.clock(), &landings);
    double sum = 0.0;
    for (int i = 0; i < 36; ++i) {
      bool first = true;
      servo.move_to(test::on_circle(i), [&](const ServoStep& step) {
        if (first && i >= 24) sum += true_distance(step.target);
        first = false;
      });
    }
    return sum / 12;
  }
};

/// A machine that its data sheet describes, but for its scatter.
test::MachineKind plain_machine() {
  test::MachineKind kind;
  kind.as_its_data_sheet = true;
  kind.scatter_m = 5e-6;
  return kind;
}

}  // namespace

TEST_CASE("What looks teach of the arm lets first landings at later targets miss by less") {
  LearningBench learning(plain_machine()), other(plain_machine());
  for (LearningBench* bench : {&learning, &other}) {
    FoundArm wrong = *bench->planner.found();
    wrong.x[0] += 100e-6;
    wrong.x[3] -= 0.012 * kDegree;
    bench->planner.plan_for(wrong);
  }
  const double learned_m = learning.first_miss_m(true), unlearned_m = other.first_miss_m(false);
  CHECK(unlearned_m > 40e-6);
  CHECK(learned_m < 15e-6);
}

TEST_CASE("The guard holds looks against the arm of the files, whatever was learned") {
  LearningBench bench(plain_machine());
  LearnedLandings landings(*bench.planner.found(), bench.planner.transmission(), true);
  bench.limits.distance_m = 0.3e-3;
  PositionServo servo(bench.settings, bench.limits, bench.planner, bench.robot, bench.sensor,
                      bench.cell.clock(), &landings);
  // A camera that moves a little at every target, so that each look alone is to be expected.
  int held = -1;
  for (int i = 0; i < 200 && held < 0; ++i) {
    bench.sensor.offset_m.x() = 5e-6 * i;
    if (servo.move_to(test::on_circle(i)).status == ServoStatus::kHeld) held = i;
  }
  CHECK(held > 0);
  CHECK(5e-6 * held < 0.4e-3);
}

}  // namespace planar
