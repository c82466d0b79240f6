#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/motion/virtual_drive.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_hardware.h"

namespace planar {

/// The arm as built, moved by its drives: the one place that knows where the tool really is now.
class VirtualArm {
 public:
  VirtualArm(const Truth& truth, const VirtualHardware& hardware, const Clock& clock);

  /// joint 0, 1 or 2; throws std::out_of_range otherwise.
  VirtualDrive& drive(int joint);

  /// The tool in the base frame: origin at P, in the lamps' plane, sag included.
  Pose X_BT();

  /// P and the direction from lamp 1 to lamp 2, which is what the tool's frame means to others.
  TipPose tip();

 private:
  /// Of links 1, 2 and the tool, each from the base's x axis.
  Eigen::Vector3d directions_rad();

  ArmTruth arm_;
  ToolTruth tool_;
  double sense_;
  std::array<bool, 2> relative_;
  std::vector<VirtualDrive> drives_;
};

}  // namespace planar
