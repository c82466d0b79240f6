#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace planar {

/// Locates an edge to a part of a pixel by the first three moments of the grey levels in a small
/// disc round a pixel, which fit a straight step between two levels [Tabatabai & Mitchell 1984].
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

}  // namespace planar
