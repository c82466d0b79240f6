#pragma once

#include <vector>

#include "planar_servo/loop/health/cause.h"

namespace planar {

/// Holds where the lamps were seen while the motors stood where they were commanded to.
struct ArmSight {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< behind their gears, radians
  LampPlaces seen_B;                      ///< in any order: lamps that are alike carry no names
  /// Deviation of a sound cell in each coordinate: of the middle of the lamps, by links and
  /// reducers between two poses, and of a lamp about the middle, by joint 3 and the lens.
  double middle_sigma_m{0.1e-3}, half_sigma_m{0.02e-3};
};

/// Finds what differs from the cell's files, from motions that were commanded and seen. Every cause
/// frees numbers of the model or changes its kind; all others stay within the usual deviations of
/// such arms and cameras. Returns the cause that explains the sights best when it is e^8 times as
/// likely as a cell without fault, and a second one that explains them nearly as well.
std::vector<HealthFinding> find_arm_faults(const CellModel& as_filed,
                                           const std::vector<ArmSight>& sights);

}  // namespace planar
