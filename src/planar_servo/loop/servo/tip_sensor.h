#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "planar_servo/base/core/pose.h"

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

}  // namespace planar
