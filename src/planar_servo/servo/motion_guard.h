#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/core/units.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

/// Holds what a calibrated cell promises about every look at its tool. The defaults of place,
/// direction and separation hold for a cell without a health record; with_health() replaces them by
/// what its calibration saw.
struct GuardLimits {
  /// The tool is seen no farther than this from where it was commanded, and turned by no more.
  double distance_m{10e-3};
  double turn{3.0 * kDegree};
  /// The distance between the lamps on the plane, uncompensated, and how far it may be off.
  double separation_m{0.0};
  double separation_tolerance_m{std::numeric_limits<double>::infinity()};
  /// The error map corrects by no more than this.
  double correction_m{std::numeric_limits<double>::infinity()};
  /// What play and noise may add to a motion or take from it.
  double play_m{0.1e-3};
  /// By how much two stops may differ from their commands by scatter alone.
  double scatter_m{0.0};
  /// The greatest uncertainty, of two standard deviations, by which a look may move the arm.
  double noise_m{50e-6};
};

/// Holds one look at the tool and what was commanded for it.
struct GuardedLook {
  TipMeasurement measurement;  ///< of a tool that was found
  TipPose commanded;           ///< by the arm's model, base frame
  double arrived_s{0.0};       ///< when the arm had come to rest
};

/// Says why a look must not move the arm.
struct Doubt {
  Refusal refusal;
  bool of_cell{false};       ///< it holds for other targets, too
  bool may_be_stray{false};  ///< one stop that missed explains it: the arm may come again
};

/// Compares a look with the command and with what the cell promises: its age, its noise, the
/// lamps' distance, the tool's place and direction, the error map's correction, and the motion
/// since the look `before`, if there was one. Returns the first doubt.
std::optional<Doubt> doubt(const GuardLimits& limits, const GuardedLook& look,
                           const GuardedLook* before);

/// Returns true when the error grew in the last two looks at a target, and by more than `noise_m`
/// explains. `errors_m` are the errors at all looks, in their order.
bool diverges(const std::vector<double>& errors_m, double noise_m);

}  // namespace planar
