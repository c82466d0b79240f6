#pragma once

#include <vector>

#include "planar_servo/health/cause.h"

namespace planar {

/// Holds where the lamps were seen while the motors stood where they were commanded to.
struct ArmSight {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< behind their gears, radians
  LampPlaces seen_B;                      ///< in any order: lamps that are alike carry no names
  /// What a sound cell may differ by, of each coordinate: the middle of the lamps, for what links
  /// and reducers do between two poses, and a lamp about the middle, for joint 3 and the lens.
  double middle_sigma_m{0.1e-3}, half_sigma_m{0.02e-3};
};

/// Finds what is not as the cell's files say from motions that were commanded and seen. Every cause
/// is tried: it frees numbers of the model, or changes it in kind, while all other numbers stay
/// within what arms and cameras of this class are off by. The cause that explains the sights best
/// is returned when it is e^8 times as likely as a cell without fault, and beside it a second one
/// that explains them nearly as well.
std::vector<HealthFinding> find_arm_faults(const CellModel& as_filed,
                                           const std::vector<ArmSight>& sights);

}  // namespace planar
