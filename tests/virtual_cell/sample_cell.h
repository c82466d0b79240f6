#pragma once

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar::test {

/// The paper's machine as its data sheets have it.
inline VirtualHardware sample_hardware() {
  VirtualHardware hardware;
  hardware.directions << 1.0, -1.0, 1.0;
  hardware.home_rad << 0.3, 1.2, 0.0;
  hardware.monuments_B = {{"datum1", {-0.45, -0.45, 0.0}}, {"datum2", {0.45, 0.45, 0.0}}};
  return hardware;
}

/// A drawn cell whose lamps shine evenly and whose rims are round.
inline Truth evenly_lit_truth(std::uint32_t seed) {
  Truth truth = draw_truth(seed);
  for (LampTruth& lamp : truth.lamps) {
    lamp.glow = GlowTruth();
    lamp.rim.clear();
  }
  return truth;
}

/// A tool at p in the base plane, turned by phi, its lamps 5 mm high.
inline Pose tool_pose(const Eigen::Vector2d& p, double phi) {
  Pose X_BT = Pose::Identity();
  X_BT.translation() << p, 0.005;
  X_BT.linear().topLeftCorner<2, 2>() = rotation2d(phi);
  return X_BT;
}

}  // namespace planar::test
