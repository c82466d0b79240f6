#include "planar_servo/virtual_cell/motion/arm_errors.h"

#include <cmath>

#include "planar_servo/core/pose.h"

namespace planar {
namespace {

// Turns of the cage, and balls that pass, per turn of a bearing of nine balls.
constexpr double kCageOrder = 0.41, kBallOrder = 3.69;
constexpr double kCageShare = 0.25, kBallShare = 0.15;
constexpr double kUneven = 0.4, kUnevenLean = 0.3;  // radians by which a turn is ahead and behind

Eigen::Vector2d towards(double angle_rad) {
  return rotation2d(angle_rad).col(0);
}

}  // namespace

Eigen::Vector2d runout_m(double joint_rad, double size_m, double phase_rad) {
  const double once = joint_rad + phase_rad + kUneven * std::sin(2.0 * joint_rad + phase_rad);
  return size_m * (towards(once) + kCageShare * towards(kCageOrder * joint_rad - phase_rad) +
                   kBallShare * towards(kBallOrder * joint_rad + 2.0 * phase_rad));
}

Eigen::Vector2d turning_runout_m(double joint_rad, double size_m, double phase_rad) {
  return size_m * std::cyl_bessel_j(0.0, kUneven) * towards(joint_rad + phase_rad);
}

Eigen::Vector2d wobble_rad(double joint_rad, double size_rad, double phase_rad) {
  return size_rad * towards(joint_rad + phase_rad + kUnevenLean * std::sin(3.0 * joint_rad));
}

double height_wave_m(const HeightWaveTruth& wave, const Eigen::Vector2d& p_B) {
  constexpr double kPerMetre = 12.0, kPerSquareMetre = 10.0;  // radians
  const double distance_m = (p_B - wave.center_m).norm();
  return wave.amplitude_m * std::cos((kPerMetre + kPerSquareMetre * distance_m) * distance_m);
}

Eigen::Vector2d bending_m(const BendingTruth& bending, double link1_rad, double link2_rad) {
  constexpr double kBalance = 3.0;  // square radians: of the elbow whose cables pull neither way
  const double turn = link1_rad - bending.slack_rad;
  const double elbow = link2_rad - link1_rad;
  const double base_pull = 2.0 * turn / (1.0 + turn * turn);
  const double elbow_pull = (elbow * elbow - kBalance) / (elbow * elbow + kBalance);
  return 0.5 * bending.largest_m *
         (base_pull * rotation2d(link1_rad).col(1) + elbow_pull * rotation2d(link2_rad).col(1));
}

}  // namespace planar
