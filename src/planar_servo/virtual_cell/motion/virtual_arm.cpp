#include "planar_servo/virtual_cell/motion/virtual_arm.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/stray.h"
#include "planar_servo/virtual_cell/truth/drawing.h"

namespace planar {
namespace {

// Corrections of the servo are shorter, ways between places longer.
constexpr double kNear = 1.0 * kDegree;

/// Returns the lean of an axis whose link before points in this direction.
Eigen::Matrix3d turned_lean(double direction_rad, const Eigen::Vector2d& lean_rad) {
  const Eigen::Vector2d lean = rotation2d(direction_rad) * lean_rad;
  return rotation_from_vector({lean.x(), lean.y(), 0.0});
}

Eigen::Vector3d in_space(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0.0};
}

}  // namespace

VirtualArm::VirtualArm(const Truth& truth, const VirtualHardware& stated, const Clock& clock)
    : arm_(truth.arm), tool_(truth.tool), outliers_(truth.outliers), seed_(truth.seed) {
  const VirtualHardware built = as_built(stated, truth.build);
  sense_ = built.sense;
  relative_ = built.relative;
  const Eigen::Vector3d scales = built.pulses_per_rad(), rated = stated.pulses_per_rad().cwiseAbs();
  const Eigen::Vector3i home = built.home_pulses(), counted = stated.home_pulses();
  for (int joint = 0; joint < 3; ++joint) {
    const MotionLimits limits{rated[joint] * stated.max_speed_rad_s[joint],
                              rated[joint] * stated.max_acceleration_rad_s2[joint]};
    drives_.emplace_back(clock,
                         VirtualDrive::Settings{scales[joint], limits, home[joint], counted[joint]},
                         arm_.reducers[static_cast<std::size_t>(joint)]);
  }
}

VirtualDrive& VirtualArm::drive(int joint) {
  return drives_.at(static_cast<std::size_t>(joint));
}

bool VirtualArm::moves() const {
  return std::any_of(drives_.begin(), drives_.end(),
                     [](const VirtualDrive& drive) { return !drive.rest_pulses(); });
}

Eigen::Vector3d VirtualArm::joints_rad() {
  return {drives_[0].output_rad(), drives_[1].output_rad(), drives_[2].output_rad()};
}

Eigen::Vector3d VirtualArm::directions_rad() {
  Eigen::Vector3d theta = joints_rad();
  if (relative_[0]) theta[1] += theta[0];
  if (relative_[1]) theta[2] += theta[1];
  return sense_ * theta;
}

double VirtualArm::sag_m(const Eigen::Vector2d& link1, const Eigen::Vector2d& link2) const {
  const double sag = arm_.sag_m_per_m2 * (link1 + link2).squaredNorm();
  if (!arm_.beam_sag) return sag;
  const double length = link1.norm();
  const double along = link1.dot(link2) / length;
  const double across = cross2d(link1, link2) / length;
  return sag +
         arm_.beam_sag->bending_m_per_m2 *
             (length * length / 3.0 + length * along + along * along) +
         arm_.beam_sag->twisting_m_per_m2 * across * across;
}

Eigen::Vector2d VirtualArm::miss_m() {
  if (!outliers_) return Eigen::Vector2d::Zero();
  const Eigen::Vector3d joints = joints_rad();
  if (rested_rad_ && (joints - *rested_rad_).cwiseAbs().maxCoeff() < kNear) return missed_m_;
  std::uint64_t place = 0;
  for (const VirtualDrive& drive : drives_) {
    const auto pulses = drive.rest_pulses();
    if (!pulses) return Eigen::Vector2d::Zero();
    place = place * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(*pulses);
  }
  Random random(seed_, RandomStream::kStray, place);
  const double length = stray_length(*outliers_, random);
  missed_m_ = any_direction(random, length, length);
  rested_rad_ = joints;
  return missed_m_;
}

Pose VirtualArm::X_BT() {
  const Eigen::Vector3d direction = directions_rad();
  const Eigen::Vector2d link1 = arm_.link_lengths_m[0] * rotation2d(direction[0]).col(0);
  const Eigen::Vector2d link2 = arm_.link_lengths_m[1] * rotation2d(direction[1]).col(0);
  const Eigen::Vector2d none(0.0, 0.0);
  const auto leans = arm_.axis_leans_rad.value_or(std::array<Eigen::Vector2d, 3>{none, none, none});
  const Eigen::Matrix3d lean1 = turned_lean(0.0, leans[0]);
  const Eigen::Matrix3d lean2 = lean1 * turned_lean(direction[0], leans[1]);
  const Eigen::Matrix3d lean3 = lean2 * turned_lean(direction[1], leans[2]);
  Pose X_BT = Pose::Identity();
  X_BT.translation() = lean1 * in_space(link1) + lean2 * in_space(link2) + in_space(miss_m());
  X_BT.translation().z() += tool_.lamp_height_m - sag_m(link1, link2);
  X_BT.linear().topLeftCorner<2, 2>() = rotation2d(direction[2]);
  X_BT.linear() = lean3 * X_BT.linear();
  return X_BT;
}

TipPose VirtualArm::tip() {
  const Pose tool = X_BT();
  const Eigen::Vector2d lamps =
      tool.linear().topLeftCorner<2, 2>() * (tool_.lamps_m[1] - tool_.lamps_m[0]);
  return {tool.translation().head<2>(), std::atan2(lamps.y(), lamps.x())};
}

}  // namespace planar
