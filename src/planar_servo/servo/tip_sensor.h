#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "planar_servo/core/pose.h"

namespace planar {

/// One look at the tool at rest, averaged over some frames; positions in the base frame.
struct TipMeasurement {
  std::string status{"ok"};  ///< or why there is no position: the rest is then not valid
  double t_s{0.0};
  int frames{0};                            ///< averaged
  std::array<Eigen::Vector2d, 2> lamps_px;  ///< mean centres on the whole sensor
  Eigen::Vector2d p_vision{0.0, 0.0};       ///< before compensation
  Eigen::Vector2d correction{0.0, 0.0};     ///< the error map's; tip.p = p_vision - correction
  TipPose tip;                              ///< compensated
  double sigma_vision_m{0.0};               ///< standard deviation per axis of ONE frame's position
  double uncertainty_m{0.0};                ///< standard uncertainty per axis of tip.p [theory: U]
  bool inside_map{true};                    ///< true as well where no map is used

  bool blind{false};  ///< no picture came at all: the camera is at fault

  bool ok() const { return status == "ok"; }
};

/// What the servo sees of camera, lamps and error map.
class TipSensor {
 public:
  virtual ~TipSensor() = default;

  /// Averages `frames` frames. `expected` is the commanded pose: where to look, and which lamp is
  /// which. A missing lamp is a status, not an exception.
  virtual TipMeasurement measure(const TipPose& expected, int frames) = 0;

  /// What keeps it from seeing now, in words; asked every few milliseconds while the arm moves.
  virtual std::optional<std::string> fault() const = 0;
};

}  // namespace planar
