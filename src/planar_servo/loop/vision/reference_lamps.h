#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_detector.h"

namespace planar {

/// How the camera's image has moved since its calibration: what was seen at r then is now seen at
///   u = r + t + M r,   p = (t_u, t_v, M_uu, M_uv, M_vu, M_vv),
/// pixels of the whole sensor. The default is no motion, with certainty.
class ImageMotion {
 public:
  using Parameters = Eigen::Matrix<double, 6, 1>;
  using Covariance = Eigen::Matrix<double, 6, 6>;

  ImageMotion() = default;
  ImageMotion(const Parameters& parameters, const Covariance& covariance)
      : p_(parameters), covariance_(covariance) {}
  /// Returns where a point seen here then is seen now.
  Eigen::Vector2d now(const Eigen::Vector2d& then_px) const;
  /// Returns where a point seen here now was seen then.
  Eigen::Vector2d then(const Eigen::Vector2d& now_px) const;
  /// Returns the covariance of then() at this place due to the motion's uncertainty.
  Eigen::Matrix2d covariance_px2(const Eigen::Vector2d& then_px) const;
  /// Returns the motion `part` of the way from this one to another, whose errors are independent.
  ImageMotion towards(const ImageMotion& other, double part) const;

  const Parameters& parameters() const { return p_; }

 private:
  Parameters p_{Parameters::Zero()};
  Covariance covariance_{Covariance::Zero()};
};

/// A fixed lamp as it was seen then and as it is now.
struct LampMove {
  Eigen::Vector2d then_px{0.0, 0.0}, now_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};  ///< of the difference
};

/// A motion fitted to fixed lamps.
struct MotionFit {
  ImageMotion motion;
  std::vector<Eigen::Vector2d> residuals_px;  ///< of each lamp, now
  double chi2{0.0};                           ///< of the residuals
  int freedom{0};                             ///< degrees of freedom that the residuals have left

  /// Returns whether noise explains the residuals.
  bool holds() const;
};

/// Fits a similarity to two moves or more: shift, turn and scale, by least squares weighted by the
/// covariances. The equations are linear. Empty when the lamps' places do not determine it.
std::optional<MotionFit> fit_similarity(const std::vector<LampMove>& moves);

/// Fits an affine map, which takes out tilt as well, to three moves or more; empty as above.
std::optional<MotionFit> fit_affine(const std::vector<LampMove>& moves);

/// Returns the simplest motion that holds: a similarity or, from four lamps on, an affine map. When
/// neither does, it returns the similarity. Empty when the lamps do not determine one.
std::optional<MotionFit> fit_image_motion(const std::vector<LampMove>& moves);

/// One fit in 3.5 million exceeds this by chance: one run of eight hours in 3600.
constexpr double kMotionSigmas = 5.0;

/// Returns the value that chi squared exceeds by chance as rarely as a normal number exceeds
/// kMotionSigmas [Wilson & Hilferty 1931]; infinite without freedom.
double greatest_chi2(int freedom);

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

/// Measures the light nearest to `place_px` in a window round it; empty if none can be measured.
std::optional<LampCenter> find_fixed_light(const Frame& frame, const Eigen::Vector2d& place_px,
                                           LampDetector& detector, CenterMethod method);

/// Watches the lamps fixed to the base, which show how the image moved since the calibration.
class ReferenceWatch {
 public:
  /// Without lamps nothing is watched: no look is ever due, and the image does not move.
  ReferenceWatch(std::vector<ReferenceLamp> lamps, CenterMethod method)
      : lamps_(std::move(lamps)), method_(method) {}
  /// Returns whether a whole frame is due at this time, before anything is concluded.
  bool is_due(double t_s) const;
  /// Looks at a whole frame. One lamp that the others contradict is left out, and logged.
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
