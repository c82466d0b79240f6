#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/readings/monument_check.h"
#include "planar_servo/core/pose.h"

namespace planar {

/// A reading of the reflector on a monument, in the tracker's frame, metres.
struct MonumentReading {
  std::string id;
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};
  double sigma{0.0};  ///< per axis, metres; zero when it is not known
};

struct MonumentResidual {
  std::string id;
  std::size_t readings{0};
  Eigen::Vector3d residual_B{0.0, 0.0, 0.0};  ///< mean reading in B minus the known position
};

struct DatumRegistration {
  Pose X_BL{Pose::Identity()};
  double rms{0.0};  ///< of the residuals' lengths over the monuments, metres
  std::vector<MonumentResidual> residuals;  ///< of the monuments used, in their order
  std::optional<std::string> left_out;      ///< the monument that moved
  Refusal doubt;  ///< what noise does not explain; empty when it explains all
};

/// Returns the monuments that were read, in their order, with the means of their readings. Throws
/// InputError as register_datum() does for readings and monuments that are wrong.
std::vector<MonumentSight> monument_sights(const std::vector<Monument>& monuments,
                                           const std::vector<MonumentReading>& readings);

/// Registers the tracker to the base by the mean of each monument's readings and its known
/// position. Throws InputError, with all faults at once, for readings of unknown monuments, values
/// that are not finite, a monument named twice, fewer than 3 monuments read or all of them on one
/// line, residuals above a hundredth of the monuments' spread, and readings that contradict the
/// monuments' places without telling which of them moved; see check_monuments(). The one that moved
/// is left out.
DatumRegistration register_datum(const std::vector<Monument>& monuments,
                                 const std::vector<MonumentReading>& readings);

}  // namespace planar
