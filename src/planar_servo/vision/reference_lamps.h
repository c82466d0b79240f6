#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/error.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/vision/image_motion.h"

namespace planar {

/// The time from one whole frame to the next. A camera that drifts by 0.4 px an hour moves by 0.003
/// px in it, less than the uncertainty that eight lamps leave.
constexpr double kReferencePeriod_s = 30.0;

/// A lamp that is fixed to the base, as the calibration saw it.
struct ReferenceLamp {
  std::string id;
  Eigen::Vector2d uv_px{0.0, 0.0};
  double sigma_px{0.0};  ///< standard deviation per axis
};

std::vector<Eigen::Vector2d> places_px(const std::vector<ReferenceLamp>& lamps);

/// Measures the light nearest to `place_px` in a window around it. Empty when there is none that
/// can be measured.
std::optional<LampCenter> find_fixed_light(const Frame& frame, const Eigen::Vector2d& place_px,
                                           LampDetector& detector, CenterMethod method);

/// Watches the lamps that are fixed to the base, which show how the image has moved since the
/// calibration.
class ReferenceWatch {
 public:
  /// Without lamps nothing is watched: no look is ever due, and the image does not move.
  ReferenceWatch(std::vector<ReferenceLamp> lamps, CenterMethod method)
      : lamps_(std::move(lamps)), method_(method) {}

  /// Returns whether a whole frame is due at this time, before anything is concluded.
  bool is_due(double t_s) const;

  /// Looks at a whole frame. One lamp that is not where the others predict it is left out, and
  /// named in the log.
  void look(const Frame& frame);

  /// Returns a whole frame's image, blackened where the fixed lamps should be.
  cv::Mat without_lamps(const cv::Mat& image) const;

  const ImageMotion& motion() const { return motion_; }
  /// Returns why the motion of the last look cannot be trusted; empty when it can.
  const std::optional<Refusal>& objection() const { return objection_; }

  const std::vector<ReferenceLamp>& lamps() const { return lamps_; }

 private:
  struct Sight {
    std::size_t lamp;
    LampMove move;
  };

  std::vector<Sight> find(const Frame& frame);
  /// Takes the motion that explains all sights, or all but one.
  void take_motion(const std::vector<Sight>& sights);
  void name_knocked(const ReferenceLamp& lamp, const LampMove& move);

  std::vector<ReferenceLamp> lamps_;
  CenterMethod method_;
  LampDetector detector_;
  ImageMotion motion_;
  std::optional<double> looked_s_;
  std::optional<Refusal> objection_;
  std::string knocked_;  ///< the lamp that was named last
};

}  // namespace planar
