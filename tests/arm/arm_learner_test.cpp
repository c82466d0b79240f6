#include "planar_servo/geometry/arm/found_arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kScatter_m = 10e-6;

/// An arm of which links and zeros are known to 3 um and 0.3 thousandths of a degree, seen by a
/// vision that is wrong by the same 20 um along x everywhere.
FoundArm plain_arm() {
  FoundArm arm;
  arm.x = Eigen::VectorXd::Zero(7);
  arm.x.head<2>() << 0.3, 0.3;
  arm.factor = Eigen::MatrixXd::Zero(7, 6);
  arm.factor.topLeftCorner<2, 2>().diagonal().setConstant(3e-6);
  arm.factor.block<3, 3>(2, 2).diagonal().setConstant(0.3e-3 * kDegree);
  arm.scatter_m = kScatter_m;
  return arm;
}

std::vector<Joints> elbow_postures() {
  std::vector<Joints> postures;
  for (double a = -kPi; a < kPi; a += 0.3)
    for (double b = 0.3; b < 2.8; b += 0.3) postures.emplace_back(a, a + b, 0.0);
  return postures;
}

Eigen::Matrix2Xd vision_off_in_x(double sigma_m) {
  Eigen::Matrix2Xd rows = Eigen::Matrix2Xd::Zero(2, 6);
  rows(0, 5) = sigma_m;
  return rows;
}

/// Looks at an arm that differs from what was found, at random postures one after the other.
struct LookedAtArm {
  FoundArm truth{plain_arm()};
  Eigen::Vector2d deviation_m{0.0, 0.0};
  Eigen::Vector2d seen_beside_m{0.0, 0.0};
  double vision_sigma_m{20e-6};
  std::mt19937 random{7};

  Eigen::Vector3d motors() {
    std::uniform_real_distribution<double> around(-kPi, kPi), elbow(0.3, 2.8);
    const double a = around(random), b = elbow(random);
    return {a, a + b, 0.0};
  }
  ArmLook look(const Eigen::Vector3d& at) {
    std::normal_distribution<double> scatter(0.0, kScatter_m);
    const double x = scatter(random), y = scatter(random);
    return {at, truth.tip(at).p + deviation_m + seen_beside_m + Eigen::Vector2d(x, y),
            vision_off_in_x(vision_sigma_m), kScatter_m};
  }
  /// Returns the mean distance between where the learned arm and where the real one is, metres.
  double error_m(const ArmLearner& learner) {
    double sum = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d at = motors();
      sum += (learner.learned().arm.tip(at).p - truth.tip(at).p - deviation_m).norm();
    }
    return sum / 200;
  }
};

ArmLearner learner() {
  return {plain_arm(), not_yet_learned(plain_arm(), elbow_postures())};
}

TEST_CASE("What is not yet learned is as it was found") {
  const LearnedArm known = not_yet_learned(plain_arm(), elbow_postures());
  CHECK(known.arm.form.posture.terms() > 10);
  const Eigen::Vector3d at(0.4, 1.6, 0.2);
  CHECK(known.arm.tip(at).p == plain_arm().tip(at).p);
  CHECK(known.covariance.diagonal().minCoeff() >= 0.0);
}

TEST_CASE("A smooth deviation that the fit did not see is learned") {
  LookedAtArm arm;
  arm.vision_sigma_m = 0.0;
  arm.deviation_m << 4e-6, -6e-6;
  ArmLearner learned = learner();
  const double before_m = arm.error_m(learned);
  for (int i = 0; i < 300; ++i) learned.take(arm.look(arm.motors()), 3.0 * i);
  CHECK(arm.error_m(learned) < 0.6 * before_m);
}

TEST_CASE("Warming links and zeros are followed") {
  LookedAtArm arm;
  ArmLearner learned = learner();
  double worst_m = 0.0;
  for (int i = 0; i < 1200; ++i) {
    const double warmth = 1.0 - std::exp(-i / 600.0);
    arm.truth.x.head<2>().setConstant(0.3 * (1.0 + 200e-6 * warmth));
    arm.truth.x[3] = 0.004 * kDegree * warmth;
    learned.take(arm.look(arm.motors()), 3.0 * i);
    if (i % 100 == 99) worst_m = std::max(worst_m, arm.error_m(learned));
  }
  const double unlearned_m = arm.error_m(learner());
  CHECK(unlearned_m > 50e-6);
  CHECK(worst_m < 0.3 * unlearned_m);
}

TEST_CASE("What vision may be wrong by is not taken for the arm's, however often it is seen") {
  LookedAtArm arm;
  arm.vision_sigma_m = 30e-6;
  arm.seen_beside_m.x() = 30e-6;
  const Eigen::Vector3d at(0.4, 1.6, 0.0);
  ArmLearner learned = learner();
  for (int i = 0; i < 500; ++i) learned.take(arm.look(at), 0.1 * i);
  const double chased_m = (learned.learned().arm.tip(at).p - arm.truth.tip(at).p).norm();
  CHECK(chased_m < 25e-6);
  const Eigen::Matrix4d known = learned.landing_covariance(at, vision_off_in_x(30e-6), 50.0);
  CHECK(known(2, 2) == Approx(30e-6 * 30e-6));
  CHECK(std::sqrt(known(0, 0)) > 0.5 * chased_m);
  // The arm that follows vision is wrong by what vision is.
  CHECK(known(0, 2) < 0.0);
}

TEST_CASE("A look that what is known does not explain teaches nothing") {
  LookedAtArm arm;
  ArmLearner learned = learner();
  for (int i = 0; i < 20; ++i) CHECK(learned.take(arm.look(arm.motors()), i) == Lesson::kTaken);
  const LearnedArm before = learned.learned();
  arm.deviation_m << 0.4e-3, 0.0;
  CHECK(learned.take(arm.look(arm.motors()), 20.0) == Lesson::kUnexpected);
  ArmLook unseen = arm.look(arm.motors());
  unseen.p.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK(learned.take(unseen, 21.0) == Lesson::kUnexpected);
  CHECK(learned.learned().arm.x == before.arm.x);
  CHECK(learned.learned().arm.factor == before.arm.factor);
  CHECK(learned.lessons() == 20);
}

TEST_CASE("No looks make an arm of it that neither warmth nor wear does") {
  LookedAtArm arm;
  ArmLearner learned = learner();
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    arm.truth.x.head<2>().setConstant(0.3 * (1.0 + 1e-6 * i));
    if (learned.take(arm.look(arm.motors()), 30.0 * i) == Lesson::kBeyondCaps) ++refused;
    const Eigen::Vector2d growth =
        learned.learned().arm.x.head<2>() / 0.3 - Eigen::Vector2d::Ones();
    REQUIRE(growth.cwiseAbs().maxCoeff() <= ArmLearner::kMostGrowth);
    REQUIRE(std::abs(learned.learned().arm.x[2]) <= ArmLearner::kMostTurn);
  }
  CHECK(refused > 0);
}

TEST_CASE("What was learned of another kind of arm is refused") {
  FoundArm other = plain_arm();
  other.factor.conservativeResize(7, 5);
  CHECK_THROWS_AS(ArmLearner(other, not_yet_learned(plain_arm(), {})), std::invalid_argument);
  other = plain_arm();
  other.form.harmonics = 1;
  CHECK_THROWS_AS(ArmLearner(other, not_yet_learned(plain_arm(), {})), std::invalid_argument);
}

}  // namespace
}  // namespace planar
