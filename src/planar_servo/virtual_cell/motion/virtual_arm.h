#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/motion/stop_scatter.h"
#include "planar_servo/virtual_cell/motion/virtual_drive.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_hardware.h"

namespace planar {

/// The arm as built, moved by its drives. It is the only place that knows the tool's true pose.
class VirtualArm {
 public:
  /// The arm is built as the truth says; its drives have the rated limits, and count at home what
  /// is stated.
  VirtualArm(const Truth& truth, const VirtualHardware& stated, const Clock& clock);
  VirtualArm(const VirtualArm&) = delete;
  VirtualArm& operator=(const VirtualArm&) = delete;

  /// Returns the drive of joint 0, 1 or 2; throws std::out_of_range for others.
  VirtualDrive& drive(int joint);

  /// Returns true while a drive turns.
  bool moves() const;

  /// Returns the tool's true pose in the base frame: origin at P in the lamps' plane, with
  /// everything that is wrong with the arm.
  Pose X_BT();

  /// Returns P and the direction from lamp 1 to lamp 2, which defines the tool's frame for the
  /// estimators.
  TipPose tip();

 private:
  /// Returns the angles behind the reducers, warm as they are.
  Eigen::Vector3d joints_rad();
  /// Returns the directions of link 1, link 2 and the tool from the base's x axis, when the joints
  /// stand at these angles.
  Eigen::Vector3d directions_rad(Eigen::Vector3d joints_rad) const;
  /// Returns the lengths of the links, warm as they are.
  Eigen::Vector2d link_lengths_m() const;
  /// Returns the orientations of the three joints' axes when links and tool have these directions.
  std::array<Eigen::Matrix3d, 3> axes(const Eigen::Vector3d& direction_rad) const;
  /// Returns the displacement of the tip by the runout of all axes.
  Eigen::Vector2d all_runout_m(const Eigen::Vector3d& direction_rad) const;
  /// Returns by how much the tool hangs lower when the links are these vectors of the plane.
  double sag_m(const Eigen::Vector2d& link1, const Eigen::Vector2d& link2) const;
  /// Returns by how much the arm misses where it came to rest, anew whenever it comes there; it
  /// stays so while the arm stays near.
  Eigen::Vector2d miss_m();
  /// Returns by how much the arm misses at this stop, or missed at the last one while it moves.
  Eigen::Vector2d scatter_m();
  /// Tells the scatter of a rest that ends.
  void leave_rest();
  /// Returns where the motors lead the tip if nothing is wrong between them and it.
  Eigen::Vector2d led_m() const;

  ArmTruth arm_;
  ToolTruth tool_;
  std::optional<OutlierTruth> outliers_;
  std::uint32_t seed_;
  const Clock& clock_;
  std::optional<StopScatter> scatter_;
  double sense_{1.0};
  std::array<bool, 2> relative_{};
  std::vector<VirtualDrive> drives_;
  std::optional<Eigen::Vector3d> rested_rad_;  ///< joints where `missed_m_` was drawn
  Eigen::Vector2d missed_m_{0.0, 0.0};
  std::unordered_map<std::uint64_t, std::uint64_t> visits_;  ///< earlier rests at a place
};

}  // namespace planar
