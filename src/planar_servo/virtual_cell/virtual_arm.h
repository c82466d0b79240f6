#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar {

// The forms of the errors of axes and links. Joint angles do not wrap after a turn.

/// Returns the runout of an axis at this angle of its joint, in the frame of the link before,
/// metres. `size_m` is the radius of the circle that it runs through unevenly once per turn; cage
/// and balls of the bearing, whose orders are not whole numbers, add two fifths of that.
Eigen::Vector2d runout_m(double joint_rad, double size_m, double phase_rad);

/// Returns the part of it that turns with the joint.
Eigen::Vector2d turning_runout_m(double joint_rad, double size_m, double phase_rad);

/// Returns the lean of an axis that turns unevenly with its joint, as the x and y of a rotation
/// vector in the frame of the link before.
Eigen::Vector2d wobble_rad(double joint_rad, double size_rad, double phase_rad);

/// Returns by how much the tool stands higher where the tip is at `p_B`.
double height_wave_m(const HeightWaveTruth& wave, const Eigen::Vector2d& p_B);

/// Returns the displacement of the tip when link 1 and link 2 have these directions: the cables of
/// the base pull at link 1, most at a radian from where they are slack and less beyond; those of
/// the elbow pull at link 2, one way when it is stretched and the other way when it is bent.
Eigen::Vector2d bending_m(const BendingTruth& bending, double link1_rad, double link2_rad);

/// Returns where the base has moved to. A thermostat heats for two fifths of the period and lets
/// cool for the rest; the base follows with a lag, and with a longer one across its direction.
Eigen::Vector2d base_shift_m(const BaseMotionTruth& motion, double time_s);

/// The miss of the tip, drawn anew at every stop. A stop is a rest of a tenth of a second or more;
/// the short rest of an approach from one side does not count, so a move goes from one real stop to
/// the next.
class StopScatter {
 public:
  StopScatter(const ScatterTruth& truth, std::uint64_t seed) : truth_(truth), seed_(seed) {}

  /// Returns the miss, base frame, of an arm that rests where its motors lead the tip to `p_m`.
  /// `negative` says that motor 1 arrived turning backwards.
  Eigen::Vector2d at_rest(const Eigen::Vector2d& p_m, bool negative) const;

  /// Notes that the arm leaves a place where it rested for this long; the other arguments are those
  /// of at_rest().
  void leave(const Eigen::Vector2d& p_m, bool negative, double rested_s);

  /// Returns the miss of an arm that moves: that of its last rest.
  const Eigen::Vector2d& moving() const { return kept_m_; }

 private:
  ScatterTruth truth_;
  std::uint64_t seed_;
  std::uint64_t stops_{0};
  std::optional<Eigen::Vector2d> last_stop_m_;
  Eigen::Vector2d kept_m_{0.0, 0.0};
};

/// The arm as built, moved by its drives. Nothing else knows the tool's true pose.
class VirtualArm {
 public:
  /// Builds the arm as the truth says; its drives have the rated limits, and count at home what is
  /// stated.
  VirtualArm(const Truth& truth, const VirtualHardware& stated, const Clock& clock);
  VirtualArm(const VirtualArm&) = delete;
  VirtualArm& operator=(const VirtualArm&) = delete;

  /// Returns the drive of joint 0, 1 or 2; throws std::out_of_range for others.
  VirtualDrive& drive(int joint) { return drives_.at(static_cast<std::size_t>(joint)); }

  /// Returns true while a drive turns.
  bool moves() const;

  /// Returns the tool's true pose in the base frame: origin at P in the lamps' plane, with
  /// everything that is wrong with the arm.
  Pose X_BT();

  /// Returns P and the direction from lamp 1 to lamp 2, which defines the tool's frame for the
  /// estimators.
  TipPose tip();

  /// Returns where the axis of joint 2 is, but for thousandths of a millimetre.
  Eigen::Vector2d elbow();

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
  /// Returns the arm's miss where it came to rest, drawn anew at each visit and kept while the arm
  /// stays near.
  Eigen::Vector2d miss_m();
  /// Returns the arm's scatter at this stop or, while it moves, at the last one.
  Eigen::Vector2d scatter_m();
  /// Returns how far the tip still is behind where it creeps to.
  Eigen::Vector2d creeping_m() const;
  /// Notes the end of a rest for scatter and creep.
  void leave_rest();
  /// Returns for how long all drives have been at rest.
  double rested_s() const;
  /// Returns where the motors would lead the tip without any error between.
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
  std::optional<Eigen::Vector2d> left_m_;  ///< where motors led the tip at the rest before
  std::unordered_map<std::uint64_t, std::uint64_t> visits_;  ///< earlier rests at a place
};

}  // namespace planar
