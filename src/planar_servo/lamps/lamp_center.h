#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"

class vpDot2;

namespace planar {

/// Describes a blob as ViSP's vpDot2 sees it, in pixels of the image.
struct VpDot {
  Eigen::Vector2d center_px{0.0, 0.0};  ///< vpDot2's own: moments of a contour of whole pixels
  Blob blob;
};

/// Follows one lamp by ViSP's vpDot2, which is initialised once and then tracks from image to
/// image. The tracker keeps the vpDot2, which recognises its blob by its size, the place of the
/// blob on the sensor, and the grey level half way between the blob and its background. Each image
/// may show another part of the sensor; `corner_px` is the sensor's pixel at the image's first one.
class VpDotTracker {
 public:
  VpDotTracker();
  VpDotTracker(VpDotTracker&&) noexcept;
  VpDotTracker& operator=(VpDotTracker&&) noexcept;
  ~VpDotTracker();

  /// Initialises vpDot2 on a blob that detection has found in the image. Empty when vpDot2 finds no
  /// blob there; then nothing is followed.
  std::optional<VpDot> start(const cv::Mat& image, const Eigen::Vector2d& corner_px,
                             const Blob& blob);

  /// Returns the blob in the next image, where it was or within two and a half of its diameters
  /// from there. Empty when it is lost, which ends the following, or when nothing is followed.
  std::optional<VpDot> track(const cv::Mat& image, const Eigen::Vector2d& corner_px);

  /// Follows nothing until it is started again.
  void forget();

 private:
  /// Calls action(patch, place in it) on the part of the image around the last place, and returns
  /// what vpDot2 then sees.
  template <typename Action>
  std::optional<VpDot> look(const cv::Mat& image, const Eigen::Vector2d& corner_px, double reach,
                            const Action& action);

  std::unique_ptr<vpDot2> dot_;  ///< in pixels of the patch that was cut out for it last
  Eigen::Vector2d place_px_{0.0, 0.0};
  int size_px_{0};
  int level_{0};
};

/// Returns the square of this half side around a pixel.
cv::Rect window_round(const Eigen::Vector2d& uv_px, double half_side_px);

/// Measures the centre of the lamp at a blob of the image, in pixels of the image. kCannyKasa:
/// Canny pixels, grey moments, Kasa's circle (the paper). kVpDot2: the centre of gravity of
/// vpDot2's contour. kFast: the centroid of the light, for even lamps only. kAuto: the outline
/// fitted to the grey levels (see fit_rim), or kNotRound when more than 100 degrees of the rim are
/// missing. A status other than kOk comes with the blob's centroid and no covariance.
LampCenter measure_lamp(const cv::Mat& image, const Blob& blob, CenterMethod method);

/// Returns the lamp that vpDot2 follows, as kVpDot2 measures it.
LampCenter lamp_at_dot(const cv::Mat& image, const VpDot& dot);

}  // namespace planar
