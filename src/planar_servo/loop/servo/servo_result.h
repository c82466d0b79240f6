#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/loop/servo/tip_sensor.h"

namespace planar {

/// Says how far, per axis, the predicted places scatter about the target: after the next
/// correction, and after later ones, when one more look has told what can be told.
struct Spread {
  double next_m{0.0}, later_m{0.0};
};

/// Says how the way to a target ended.
enum class ServoStatus {
  kReached,       ///< the servo is content, within the map's valid region
  kDoubted,       ///< was reached, and the cell was found not to be well when next looked at
  kOutsideMap,    ///< the servo is content, but the error map is not valid here
  kNotConverged,  ///< the iterations were used up, or no correction is expected to help
  kDiverged,      ///< looks contradict those before them; the drives were halted
  kHeld,          ///< a look contradicts the command or the calibration; nothing moved after it
  kLostLamp,      ///< the tool was not measured; nothing moved after that
  kLostCamera,    ///< the camera failed; the arm stopped where it was
  kRefused,       ///< target or correction beyond reach, workspace, limits, or near a singularity
};

/// All statuses with their names in files.
constexpr Named<ServoStatus> kServoStatuses[] = {
    {ServoStatus::kReached, "reached"},        {ServoStatus::kDoubted, "doubted"},
    {ServoStatus::kOutsideMap, "outside_map"}, {ServoStatus::kNotConverged, "not_converged"},
    {ServoStatus::kDiverged, "diverged"},      {ServoStatus::kHeld, "held"},
    {ServoStatus::kLostLamp, "lost_lamp"},     {ServoStatus::kLostCamera, "lost_camera"},
    {ServoStatus::kRefused, "refused"}};

/// Returns the status's name.
const char* name(ServoStatus status);

/// Holds the estimate by command and all looks at a target so far; base frame, metres, per axis.
struct LandingEstimate {
  Eigen::Vector2d p{0.0, 0.0};           ///< where the end point is expected to rest
  double deviation_m{0.0};               ///< of p, by vision, field and arm together
  Eigen::Vector2d correction{0.0, 0.0};  ///< how far to shift the commanded place
  Spread spread;                         ///< after that correction and further ones
  double scatter_m{0.0};                 ///< of a stop after such a correction, as looks show it
  bool is_contradicted{false};           ///< this look and the one before were unexpected
  /// The arm has strayed, or the view has changed: approaching again from afar tells which.
  bool seems_strayed{false};
};

/// Records one measurement at rest: number 0 after the open-loop move, then one per correction.
struct ServoStep {
  int iteration{0};
  TipPose target;
  TipMeasurement measurement;
  Eigen::Vector2d error{0.0, 0.0};  ///< target minus measured position; valid with the measurement
  double turn_error{0.0};           ///< the same for the tool's direction, radians
  double stop_below_m{0.0};         ///< the servo is content when miss_m() is below this
  Joints theta_c{0.0, 0.0, 0.0};    ///< commanded joints
  Pulses pulses_c{0, 0, 0};         ///< commanded pulses
  /// Empty where the last look is accepted as it is, and where it is doubted or gave no position.
  std::optional<LandingEstimate> estimate{};

  /// The following are valid with the measurement.
  Eigen::Vector2d believed_p() const { return estimate ? estimate->p : measurement.tip.p; }
  /// Returns the standard deviation of believed_p() per axis.
  double uncertainty_m() const {
    return estimate ? estimate->deviation_m : measurement.uncertainty_m;
  }
  /// Returns how the arm stands for a judge; always valid.
  Standing standing() const {
    return {theta_c, measurement.ok() ? std::optional(measurement.tip) : std::nullopt};
  }
  /// Returns how far from the target the end point is believed to be.
  double miss_m() const { return (target.p - believed_p()).norm(); }
};

/// Records the way to one target and how it ended.
struct ServoResult {
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;  ///< the reason in words; empty when the target was reached
  /// The cell itself is in doubt: another target would fare no better, or worse.
  bool cell_in_doubt{false};
  TipPose target;
  int iterations{0};  ///< number of corrections made
  std::vector<ServoStep> steps;
  double duration_s{0.0};
};

/// Returns why the servo stopped after its last step, in words; empty when the target was reached.
/// This turn of the tool and this many corrections were allowed.
std::string reason_for(ServoStatus status, const ServoStep& last, double orientation_tolerance,
                       int max_iterations);

}  // namespace planar
