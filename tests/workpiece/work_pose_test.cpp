#include "planar_servo/workpiece/work_pose.h"

#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kNoise_m = 5e-6;
constexpr double kTurn = 0.3;
const Eigen::Vector2d kOrigin(0.2, -0.1);

WorkMarks marks_at(const std::vector<Eigen::Vector2d>& places_W) {
  const auto n = static_cast<Eigen::Index>(places_W.size());
  WorkMarks marks{{},
                  Eigen::Matrix2Xd(2, n),
                  Eigen::Matrix2Xd(2, n),
                  kNoise_m * kNoise_m * Eigen::MatrixXd::Identity(2 * n, 2 * n),
                  Eigen::MatrixXd::Zero(2 * n, 2 * n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    marks.ids.push_back("F" + std::to_string(i + 1));
    marks.p_W.col(i) = places_W[static_cast<std::size_t>(i)];
    marks.p_B.col(i) = rotation2d(kTurn) * marks.p_W.col(i) + kOrigin;
  }
  return marks;
}

WorkMarks four_marks() {
  return marks_at({{0.0, 0.0}, {0.15, 0.0}, {0.15, 0.1}, {0.0, 0.08}});
}

}  // namespace

TEST_CASE("Marks without noise give the pose back, whatever map is fitted") {
  for (const WorkMap map : {WorkMap::kRigid, WorkMap::kSimilarity, WorkMap::kAffine}) {
    const auto fit = fit_work(four_marks(), map);
    REQUIRE(fit);
    CHECK((fit->pose.t - kOrigin).norm() < 1e-12);
    CHECK(fit->pose.turn() == Approx(kTurn).margin(1e-12));
    CHECK(fit->pose.scale() == Approx(1.0).margin(1e-12));
    CHECK(fit->chi2 < 1e-12);
  }
}

TEST_CASE("A work's pose is as uncertain as its covariance says, away from its marks, too") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, kNoise_m);
  const WorkMarks exact = four_marks();
  const Eigen::Vector2d target(0.3, -0.2);
  const Eigen::Vector2d wanted = rotation2d(kTurn) * target + kOrigin;
  int within = 0, chances_below_half = 0;
  constexpr int kWorks = 2000;
  for (int i = 0; i < kWorks; ++i) {
    WorkMarks marks = exact;
    for (double& x : marks.p_B.reshaped()) x += normal(random);
    const auto fit = fit_work(marks, WorkMap::kRigid);
    REQUIRE(fit);
    const Eigen::Vector2d miss = fit->pose.in_base(target) - wanted;
    const Eigen::Matrix2d covariance = fit->pose.covariance_at(target);
    for (Eigen::Index axis = 0; axis < 2; ++axis)
      within += std::abs(miss[axis]) < 1.96 * std::sqrt(covariance(axis, axis));
    chances_below_half += fit->chance() < 0.5;
  }
  CHECK(within > 0.94 * 2 * kWorks);
  CHECK(within < 0.96 * 2 * kWorks);
  CHECK(chances_below_half > 0.46 * kWorks);
  CHECK(chances_below_half < 0.54 * kWorks);
}

TEST_CASE("Four marks determine the height that they share, and its residuals are the marks' own") {
  WorkMarks marks = four_marks();
  // A camera 1 m above (0.1, 0.1): a millimetre of height moves each mark away from its foot.
  Eigen::VectorXd raised(8);
  for (Eigen::Index i = 0; i < 4; ++i)
    raised.segment<2>(2 * i) = -(marks.p_B.col(i) - Eigen::Vector2d(0.1, 0.1)) / 1.0;
  constexpr double kSigmaHeight_m = 1e-3;
  marks.shared = kSigmaHeight_m * kSigmaHeight_m * raised * raised.transpose();
  marks.p_B += 1.5e-3 * raised.reshaped(2, 4);
  const auto fit = fit_work(marks, WorkMap::kRigid);
  REQUIRE(fit);
  CHECK((fit->pose.t - kOrigin).norm() < 5e-6);
  CHECK(fit->residuals.norm() < kNoise_m);
  CHECK(fit->chance() > kFalseAlarm);
}

TEST_CASE(
    "One mark that contradicts the others is named, and two marks cannot contradict each other") {
  WorkMarks marks = four_marks();
  marks.p_B.col(2) += Eigen::Vector2d(2e-4, 0.0);
  const auto odd = contradicting_mark(marks, WorkMap::kRigid);
  REQUIRE(odd);
  CHECK(odd->mark == 2);
  CHECK(odd->distance_m == Approx(2e-4).epsilon(0.05));
  CHECK_FALSE(contradicting_mark(four_marks(), WorkMap::kAffine));
  WorkMarks two = marks_at({{0.0, 0.0}, {0.15, 0.0}});
  two.p_B.col(1) += Eigen::Vector2d(2e-4, 0.0);
  CHECK_FALSE(contradicting_mark(two, WorkMap::kRigid));
  CHECK(fit_work(two, WorkMap::kRigid)->chance() < kFalseAlarm);
}

TEST_CASE("A mark is told to contradict the others however uncertain all of them are together") {
  WorkMarks marks = four_marks();
  constexpr double kShared_m = 1e-4;
  marks.shared = (kShared_m * kShared_m * Eigen::Matrix2d::Identity()).replicate(4, 4);
  marks.p_B.col(2) += Eigen::Vector2d(10.0 * kNoise_m, 0.0);
  const auto odd = contradicting_mark(marks, WorkMap::kRigid);
  REQUIRE(odd);
  CHECK(odd->mark == 2);
}

TEST_CASE("A similarity takes a shrunk print, an affine map a skewed one") {
  WorkMarks shrunk = four_marks();
  shrunk.p_B = ((0.998 * rotation2d(kTurn)) * shrunk.p_W).colwise() + kOrigin;
  CHECK(fit_work(shrunk, WorkMap::kRigid)->chance() < kFalseAlarm);
  CHECK(fit_work(shrunk, WorkMap::kSimilarity)->pose.scale() == Approx(0.998).epsilon(1e-9));
  WorkMarks skewed = four_marks();
  Eigen::Matrix2d A;
  A << 1.0, 0.002, 0.0, 0.999;
  skewed.p_B = (A * skewed.p_W).colwise() + kOrigin;
  CHECK(fit_work(skewed, WorkMap::kSimilarity)->chance() < kFalseAlarm);
  CHECK((fit_work(skewed, WorkMap::kAffine)->pose.A - A).norm() < 1e-9);
}

TEST_CASE("Marks in one place determine no pose") {
  CHECK_FALSE(fit_work(marks_at({{0.1, 0.0}}), WorkMap::kRigid));
  CHECK_FALSE(fit_work(marks_at({{0.1, 0.0}, {0.2, 0.0}, {0.3, 0.0}}), WorkMap::kAffine));
}

}  // namespace planar
