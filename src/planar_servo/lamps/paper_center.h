#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "planar_servo/lamps/blob.h"

namespace planar {

/// Locates an edge to sub-pixel accuracy by the first three moments of the grey levels in a small
/// disc around a pixel, which fit a straight step between two levels [Tabatabai & Mitchell 1984].
class GreyMoments {
 public:
  /// Takes the disc inscribed in a window of (2 half_width + 1)^2 pixels; half_width is at least 1.
  explicit GreyMoments(int half_width);

  /// Returns the radius of the disc in pixels.
  double radius_px() const { return half_width_ + 0.5; }

  /// Returns the point of the edge nearest to `pixel`, in pixels of the image. Empty when the
  /// window leaves the image or is saturated, the step is smaller than `least_contrast`, or the
  /// edge is more than one pixel away.
  std::optional<Eigen::Vector2d> edge(const cv::Mat& image, const cv::Point& pixel,
                                      double least_contrast) const;

 private:
  struct Sample {
    int du, dv;
    double weight;  ///< area of the pixel inside the disc; the weights sum to 1
  };

  int half_width_;
  std::vector<Sample> samples_;
};

/// Returns the window of grey moments for a lamp of the blob's size.
const GreyMoments& moments_for(const Blob& blob);

/// Returns how many pixels must lie beyond a blob's box for the windows to stay in the image.
int least_margin_px(const GreyMoments& moments);

/// Returns the edge points of the lamp at a blob, in pixels of the image: Canny's pixels about the
/// blob's ellipse, each moved to the edge that the grey moments find there. The image is CV_8UC1,
/// and at least least_margin_px() of its pixels lie beyond the blob's box.
std::vector<Eigen::Vector2d> canny_edges(const cv::Mat& image, const Blob& blob);

struct Circle {
  Eigen::Vector2d center{0.0, 0.0};
  double radius{0.0};
};

/// Returns the circle that minimises the sum of (x^2 + y^2 + a x + b y + c)^2, in closed form [Kasa
/// 1976]. Empty for fewer than three points and for points nearly on one line.
std::optional<Circle> kasa_circle(const std::vector<Eigen::Vector2d>& points);

/// The residual of an edge point after a fit.
struct EdgeResidual {
  double angle{0.0};     ///< of the point round the rim's centre, radians
  double distance{0.0};  ///< of the point from the fitted rim
};

/// Returns how many edges along the rim count as one independent edge: 1 + 2 sum_k (1 - k / (reach
/// + 1)) rho_k, with the autocorrelation rho_k of the residuals in order of their angle [Newey &
/// West 1987]. Edges more than `reach` apart in this order share no pixels. The result is bounded
/// to 1 / 2 and reach + 1, because few residuals prove no less.
double edges_per_independent(std::vector<EdgeResidual> residuals, int reach);

}  // namespace planar
