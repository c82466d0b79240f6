#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "planar_servo/core/pose.h"

namespace planar {

/// Whether a look at the tool gave its position, and else what is missing.
enum class TipStatus {
  kOk,
  kNoPicture,    ///< no picture came: the camera is at fault
  kNoLamps,      ///< the picture does not show both lamps as it should
  kOutsideView,  ///< the camera does not see the place where the tool should be
  kNotFinite,    ///< the position came out as no finite number
};

/// One look at the tool at rest, averaged over some frames; positions in the base frame. Unless
/// `status` is kOk, only `status`, `word` and `t_s` are valid.
struct TipMeasurement {
  TipStatus status{TipStatus::kOk};
  std::string word{"ok"};  ///< the status in one word for tables: "ok", "one_lamp", "no_frame", ...
  double t_s{0.0};
  int frames{0};                          ///< how many were averaged
  std::array<Eigen::Vector2d, 2> lamps_px{///< mean centres on the whole sensor
                                          Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  Eigen::Vector2d p_vision{0.0, 0.0};    ///< before compensation
  Eigen::Vector2d correction{0.0, 0.0};  ///< by the error map; tip.p = p_vision - correction
  TipPose tip;                           ///< compensated
  double sigma_vision_m{0.0};            ///< standard deviation per axis of ONE frame's position
  double uncertainty_m{
      0.0};               ///< standard uncertainty per axis of tip.p, of vision and map together
  bool inside_map{true};  ///< true as well where no map is used

  bool ok() const { return status == TipStatus::kOk; }
};

/// A look that gave no position.
TipMeasurement failed_look(TipStatus status, const std::string& word, double t_s);

/// What the servo sees of camera, lamps and error map.
class TipSensor {
 public:
  virtual ~TipSensor() = default;

  /// Averages `frames` frames. `expected` is the commanded pose, which tells where to look and
  /// which lamp is which. A missing lamp is a status, not an exception.
  virtual TipMeasurement measure(const TipPose& expected, int frames) = 0;

  /// What keeps it from seeing now, in words. It is asked every few milliseconds while the arm
  /// moves.
  virtual std::optional<std::string> fault() const = 0;
};

}  // namespace planar
