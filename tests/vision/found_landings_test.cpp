#include "planar_servo/loop/vision/found_landings.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kColumns = 3;

LampField some_field(Eigen::Index columns) {
  LampField field;
  field.basis = basis_over_disc(0.6, 0.3);
  field.weights.setZero(field.basis.terms(), 2);
  field.factor = 1e-5 * Eigen::MatrixXd::Random(field.unknowns(), columns);
  field.region.hull = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  return field;
}

FoundArm some_arm(Eigen::Index columns) {
  FoundArm arm;
  arm.form.joints_per_motor << 1, 0, 0, 1, 1, 0, 1, 1, 1;
  arm.x.head<2>() << 0.3, 0.3;
  arm.factor = 1e-5 * Eigen::MatrixXd::Random(arm.form.terms(), columns);
  arm.scatter_m = 4e-6;
  return arm;
}

Transmission free_motors() {
  TransmissionSettings settings;
  for (Eigen::Vector2d& limits : settings.limits_rad) limits << -360 * kDegree, 360 * kDegree;
  return Transmission(settings);
}

TEST_CASE("What is known of a landing is J U U^T J^T of arm and sight, never negative") {
  const LampField field = some_field(kColumns);
  const FoundArm arm = some_arm(kColumns);
  const FoundLandings landings(field, arm, free_motors(), 2e-3);
  const Joints theta(0.3, 1.5, -0.4);
  TipMeasurement look;
  look.lamps_B = {Eigen::Vector2d(0.3, 0.35), Eigen::Vector2d(0.3, 0.39)};
  const LandingPrior prior = landings.at(theta, look);
  // The rows by differences: the arm's landing, and minus what vision, compensated, says.
  const Eigen::Vector3d motors(0.3, 1.2, -1.9);
  Eigen::MatrixXd rows(4, kColumns);
  for (Eigen::Index k = 0; k < kColumns; ++k) {
    FoundArm other_arm = arm;
    other_arm.x += arm.factor.col(k);
    rows.col(k).head<2>() = other_arm.tip(motors).p - arm.tip(motors).p;
    LampField other = field;
    const Eigen::VectorXd off = field.factor.col(k);
    const Eigen::Index nb = field.basis.terms();
    other.weights.col(0) += off.head(nb);
    other.weights.col(1) += off.segment(nb, nb);
    other.height += off.segment(2 * nb, 3);
    other.tool.p_TP += off.tail<2>();
    rows.col(k).tail<2>() =
        compensate(field, look.lamps_B).tip.p - compensate(other, look.lamps_B).tip.p;
  }
  const Eigen::MatrixXd expected = rows * rows.transpose();
  CHECK((prior.covariance - expected).norm() < 0.01 * expected.norm());
  CHECK(symmetric_eigenvalues(prior.covariance)[0] > -1e-12 * expected.norm());
  CHECK(prior.covariance.topRightCorner<2, 2>().norm() > 0.01 * expected.norm());
  CHECK(prior.scatter_m == 4e-6);
  CHECK(prior.stray_m == 2e-3);
}

TEST_CASE("A field and an arm that were not found together are refused") {
  CHECK_THROWS_AS(FoundLandings(some_field(3), some_arm(4), free_motors(), 0.0),
                  std::invalid_argument);
}

TEST_CASE("An arm of no scatter is not believed to have none") {
  FoundArm arm = some_arm(kColumns);
  arm.scatter_m = 0.0;
  const FoundLandings landings(some_field(kColumns), arm, free_motors(), 0.0);
  TipMeasurement look;
  look.lamps_B = {Eigen::Vector2d(0.3, 0.35), Eigen::Vector2d(0.3, 0.39)};
  CHECK(landings.at({0.3, 1.5, -0.4}, look).scatter_m > 0.0);
}

/// A first look at a stop that is seen beside where this arm lands.
SeenLanding seen_beside(const FoundArm& arm, const Eigen::Vector2d& off_m, bool has_strayed) {
  SeenLanding seen;
  seen.theta_c = {0.3, 1.5, -0.4};
  seen.look.tip.p = arm.tip(free_motors().motors_from_joints(seen.theta_c)).p + off_m;
  seen.look.lamps_B = {Eigen::Vector2d(0.3, 0.35), Eigen::Vector2d(0.3, 0.39)};
  seen.scatter_m = 4e-6;
  seen.has_strayed = has_strayed;
  return seen;
}

TEST_CASE(
    "What was learned is forgotten where the arm as it was found lands right, and it does not") {
  const FoundArm arm = some_arm(kColumns);
  LearningLandings landings(some_field(kColumns), arm, unlearned(arm, PostureBasis{}),
                            free_motors(), 2e-3);
  const Eigen::Vector2d off(30e-6, 20e-6);
  landings.learn(seen_beside(arm, off, false));
  CHECK(landings.learner().lessons() == 1);
  landings.learn(seen_beside(arm, {1e-3, 0.0}, true));
  CHECK(landings.learner().lessons() == 1);  // a stray that nobody explains takes nothing back
  landings.learn(seen_beside(arm, {0.0, 0.0}, true));
  CHECK(landings.learner().lessons() == 0);
  CHECK(landings.learned_arm()->x == arm.x);
}

TEST_CASE("Where the arm stays off, the lamps tell whether it strayed or the view has changed") {
  const FoundArm arm = some_arm(kColumns);
  FoundLandings landings(some_field(kColumns), arm, free_motors(), 2e-3);
  SeenLanding off = seen_beside(arm, {1e-3, 0.0}, true);
  off.stays_off = true;
  landings.learn(off);
  REQUIRE(landings.doubt());
  CHECK_FALSE(landings.doubt()->of_cell);  // nobody knows yet
  for (int i = 0; i < 6; ++i) landings.learn(seen_beside(arm, {0.0, 0.0}, false));
  CHECK_FALSE(landings.doubt());
  landings.learn(off);
  REQUIRE(landings.doubt());
  CHECK_FALSE(landings.doubt()->of_cell);  // nor when both lamps are displaced alike
  off.look.lamps_B[1].y() += 0.05e-3;
  landings.learn(off);
  REQUIRE(landings.doubt());
  CHECK(landings.doubt()->of_cell);
}

TEST_CASE("Looks that neither arm nor field explain are a doubt, with and without learning") {
  const FoundArm arm = some_arm(kColumns);
  FoundLandings found(some_field(kColumns), arm, free_motors(), 2e-3);
  LearningLandings learning(some_field(kColumns), arm, unlearned(arm, PostureBasis{}),
                            free_motors(), 2e-3);
  for (int i = 0; i < 10; ++i) {
    const SeenLanding seen = seen_beside(arm, {0.0, 0.5e-3}, false);
    found.learn(seen);
    learning.learn(seen);
  }
  REQUIRE(found.doubt());
  CHECK(found.doubt()->of_cell);
  CHECK(found.doubt()->fault.find("0.5") != std::string::npos);
  CHECK(learning.doubt());
}

}  // namespace
}  // namespace planar
