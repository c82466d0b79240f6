#include "planar_servo/loop/vision/found_landings.h"

#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kStops_m = 10e-6;

/// An arm whose links are known to 3 um, its zeros to 0.3 thousandths of a degree.
FoundArm followed_arm() {
  FoundArm arm;
  arm.x.head<2>().setConstant(0.3);
  arm.factor = Eigen::MatrixXd::Zero(7, 5);
  arm.factor.topLeftCorner<2, 2>().diagonal().setConstant(3e-6);
  arm.factor.block<3, 3>(2, 2).diagonal().setConstant(0.3e-3 * kDegree);
  arm.scatter_m = kStops_m;
  return arm;
}

/// Shows first looks at random targets, two seconds apart, of an arm and a vision that may differ
/// from what was found.
struct FollowedArm {
  FoundArm truth{followed_arm()};
  Eigen::Vector2d seen_beside_m{0.0, 0.0}, grows_m_s{0.0, 0.0};
  std::mt19937 random{3};
  FollowingError following{followed_arm()};
  double t_s{0.0};

  ArmLook look() {
    std::uniform_real_distribution<double> around(-kPi, kPi), elbow(0.3, 2.8);
    std::normal_distribution<double> scatter(0.0, kStops_m);
    const double a = around(random), b = elbow(random), x = scatter(random), y = scatter(random);
    const Eigen::Vector3d motors(a, a + b, 0.0);
    return {motors, truth.tip(motors).p + seen_beside_m + t_s * grows_m_s + Eigen::Vector2d(x, y),
            Eigen::Matrix2Xd::Zero(2, 5), kStops_m};
  }
  /// Returns after how many targets there was a doubt; so many as there are when there was none.
  int doubted_after(int targets) {
    for (int i = 0; i < targets; ++i, t_s += 2.0) {
      if (following.doubt()) return i;
      following.take(look(), t_s);
    }
    return targets;
  }
};

TEST_CASE("An arm that lands where it was found to is followed for ever") {
  FollowedArm arm;
  CHECK(arm.doubted_after(2000) == 2000);
}

TEST_CASE("An arm that has grown warm is not doubted") {
  FollowedArm arm;
  arm.truth.x.head<2>() *= 1.0 + 120e-6;
  arm.truth.x[2] += 0.002 * kDegree;
  CHECK(arm.doubted_after(1000) == 1000);
}

TEST_CASE("A shift of all looks by 0.1 mm is a doubt within ten targets, one by 0.02 mm is none") {
  FollowedArm arm;
  arm.seen_beside_m = {60e-6, -80e-6};
  CHECK(arm.doubted_after(100) < 10);
  CHECK(arm.following.doubt().value().fault.find("0.1") != std::string::npos);
  FollowedArm other;
  other.seen_beside_m = {20e-6, 0.0};
  CHECK(other.doubted_after(200) == 200);
}

TEST_CASE("A drift is a doubt before it has cost 0.1 mm") {
  FollowedArm arm;
  arm.grows_m_s = {0.0, 1e-6};
  const int targets = arm.doubted_after(200);
  CHECK(targets > 15);
  CHECK(2.0 * targets * arm.grows_m_s.norm() < 0.1e-3);
}

TEST_CASE("What the arm as it was found explains is told from what it does not") {
  FollowedArm arm;
  CHECK(arm.following.explains(arm.look()));
  arm.seen_beside_m = {0.3e-3, 0.0};
  CHECK_FALSE(arm.following.explains(arm.look()));
}

}  // namespace
}  // namespace planar
