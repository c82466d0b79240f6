#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"

namespace planar {

/// A monument's known position, in any frame, and its position as read by the tracker, in the
/// tracker's frame.
struct MonumentSight {
  std::string id;
  Eigen::Vector3d p_known{0.0, 0.0, 0.0};  ///< metres
  Eigen::Vector3d p_read{0.0, 0.0, 0.0};   ///< mean of its readings
  std::size_t readings{1};
  double sigma{0.0};  ///< of one reading per axis, metres; zero when it is not known
};

/// What the readings of the monuments show.
struct MonumentVerdict {
  /// The only monument without which the others fit.
  std::optional<std::size_t> moved;
  Refusal doubt;        ///< with sizes; empty when the readings fit
  bool refused{false};  ///< whether these readings must not be used
};

/// Compares the monuments' relative positions as read with those of the cell file, by the sum of
/// squares that a rigid fit leaves. It is tested against two uncertainties, each with a false-alarm
/// rate of kFalseAlarm. The mean of n readings may be as good as sigma / sqrt(n): what this does
/// not explain is doubted. But sigma may also be common to all readings of a monument: what even
/// this does not explain is a contradiction. The one monument that explains it is then named as
/// moved; where no single one does, or there are only three, the readings are refused. Four
/// monuments in one plane show that one of them rose or sank, but not which one; three do not show
/// it at all. Two show their distance.
MonumentVerdict check_monuments(const std::vector<MonumentSight>& monuments);

/// Compares the readings (p_read) of the same monuments at the beginning and at the end of a
/// recording. What the noise of the means does not explain is doubted; what the noise of single
/// readings does not explain is refused. The message distinguishes a tracker that moved from a
/// single monument that did.
MonumentVerdict check_drift(const std::vector<MonumentSight>& begin,
                            const std::vector<MonumentSight>& end);

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
/// InputError for wrong readings and monuments, as register_datum() does.
std::vector<MonumentSight> monument_sights(const std::vector<Monument>& monuments,
                                           const std::vector<MonumentReading>& readings);

/// Registers the tracker to the base by the mean of each monument's readings and its known
/// position. Throws InputError, with all faults at once, for readings of unknown monuments, values
/// that are not finite, a monument named twice, fewer than 3 monuments read or all of them on one
/// line, residuals above a hundredth of the monuments' spread, and readings that contradict the
/// monuments' positions without showing which one moved; see check_monuments(). A monument that
/// moved is left out.
DatumRegistration register_datum(const std::vector<Monument>& monuments,
                                 const std::vector<MonumentReading>& readings);

}  // namespace planar
