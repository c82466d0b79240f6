#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// Says whether a look at the tool gave its position, and otherwise what is missing.
enum class TipStatus {
  kOk,
  kNoPicture,    ///< the camera delivered no picture
  kNoLamps,      ///< the picture does not show both lamps as it should
  kOutsideView,  ///< the camera does not see the place where the tool should be
  kNotFinite,    ///< the computed position is not a finite number
};

/// Holds one look at the tool at rest, averaged over some frames. Positions are in the base frame,
/// metres. Unless `status` is kOk, only `status`, `word` and `t_s` are valid.
struct TipMeasurement {
  TipStatus status{TipStatus::kOk};
  std::string word{"ok"};  ///< the status in one word for tables: "ok", "one_lamp", "no_frame", ...
  double t_s{0.0};
  int frames{0};  ///< number of frames averaged
  /// The mean centres of the lamps on the whole sensor.
  std::array<Eigen::Vector2d, 2> lamps_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  /// Their places on the plane of the lamps' motion, uncompensated.
  std::array<Eigen::Vector2d, 2> lamps_B{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  Eigen::Vector2d p_vision{0.0, 0.0};    ///< position before compensation
  Eigen::Vector2d correction{0.0, 0.0};  ///< predicted error: tip.p = p_vision - correction
  TipPose tip;                           ///< compensated pose
  /// The standard deviation per axis that the frames' noise leaves in the position.
  double noise_m{0.0};
  /// The standard uncertainty per axis of tip.p, of vision and map together.
  double uncertainty_m{0.0};
  double turn_sigma{0.0};  ///< of tip.phi, by the frames' noise, radians
  bool inside_map{true};   ///< also true when no map is used

  /// Returns true when the position is valid.
  bool ok() const { return status == TipStatus::kOk; }
};

/// Returns a look that gave no position.
inline TipMeasurement failed_look(TipStatus status, const std::string& word, double t_s) {
  TipMeasurement measurement;
  measurement.status = status;
  measurement.word = word;
  measurement.t_s = t_s;
  return measurement;
}

/// Measures the end point for the servo, by whatever means.
class TipSensor {
 public:
  virtual ~TipSensor() = default;
  /// Measures the tool in so many frames and averages them. `expected` is the commanded pose, which
  /// tells where to look and which lamp is which. A missing lamp is a status, no exception.
  virtual TipMeasurement measure(const TipPose& expected, int frames) = 0;
  /// Returns what keeps it from seeing now; asked every few milliseconds while the arm moves.
  virtual std::optional<std::string> fault() const = 0;
};

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
