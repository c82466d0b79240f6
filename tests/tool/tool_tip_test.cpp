#include "planar_servo/geometry/tool/tips.h"

#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

const Eigen::Vector2d kTip(0.03, -0.004), kMark(0.25, 0.12);
constexpr double kSigma_m = 5e-6;

std::vector<TipAtMark> at_mark(const std::vector<double>& directions_deg, std::mt19937* random) {
  std::normal_distribution<double> normal(0.0, kSigma_m);
  std::vector<TipAtMark> poses;
  for (const double deg : directions_deg) {
    const double phi = deg * kDegree;
    Eigen::Vector2d p = end_point_for(kMark, phi, kTip);
    if (random != nullptr)
      for (double& x : p) x += normal(*random);
    poses.push_back({"T" + std::to_string(poses.size() + 1), {p, phi}});
  }
  return poses;
}

}  // namespace

TEST_CASE("Poses without noise give tip and mark back") {
  const TaughtTip taught = teach_tip(at_mark({0, 120, 240}, nullptr), kSigma_m);
  CHECK((taught.tip.p_TE - kTip).norm() < 1e-12);
  CHECK((taught.mark_B - kMark).norm() < 1e-12);
}

TEST_CASE("Four even directions leave half the deviation of a pose in the tip, as it says") {
  std::mt19937 random(1);
  int within = 0;
  constexpr int kTools = 1000;
  for (int i = 0; i < kTools; ++i) {
    const TaughtTip taught = teach_tip(at_mark({0, 90, 180, 270}, &random), kSigma_m);
    const double sigma = per_axis(taught.tip.covariance);
    CHECK(sigma >= 0.499 * kSigma_m);
    within +=
        static_cast<int>(((taught.tip.p_TE - kTip).cwiseAbs().array() < 1.96 * sigma).count());
  }
  CHECK(within > 0.94 * 2 * kTools);
}

TEST_CASE("A slip is refused, and named where four poses tell which") {
  auto poses = at_mark({0, 90, 180, 270, 45}, nullptr);
  poses[2].pose.p.x() += 2e-4;
  CHECK_THROWS_MATCHES(teach_tip(poses, kSigma_m), WorkError, Refused(Cause::kContradiction, "T3"));
  auto three = at_mark({0, 120, 240}, nullptr);
  three[1].pose.p.y() += 2e-4;
  CHECK_THROWS_AS(teach_tip(three, kSigma_m), WorkError);
}

TEST_CASE("Fewer than three directions show no slip and are refused") {
  CHECK_THROWS_AS(teach_tip(at_mark({0, 180}, nullptr), kSigma_m), InputError);
  CHECK_THROWS_AS(teach_tip(at_mark({0, 5, 180, 185}, nullptr), kSigma_m), InputError);
}

TEST_CASE("A bent tip misses the mark at which it was taught") {
  const TaughtTip taught = teach_tip(at_mark({0, 90, 180, 270}, nullptr), kSigma_m);
  TipPose pose{end_point_for(kMark, 0.3, kTip), 0.3};
  CHECK(miss_of(taught, pose).off.norm() < 1e-12);
  pose.p += Eigen::Vector2d(1e-4, 0.0);
  CHECK(miss_of(taught, pose).off.norm() > 3.0 * miss_of(taught, pose).sigma);
}

}  // namespace planar
