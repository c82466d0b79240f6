#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lamps/cramer_rao.h"
#include "planar_servo/lamps/blob.h"

namespace planar::bench {

/// Holds a measured centre.
struct Measured {
  Eigen::Vector2d uv_px;
  std::optional<Eigen::Matrix2d> covariance_px2;  ///< present for methods that state one
};

/// A way to measure the one lamp of a window. `measure` returns nothing when it finds no lamp.
/// `reset` brings a method that follows lamps from frame to frame back to this frame, and is not
/// timed.
struct CenterMethodUnderTest {
  std::string name;
  std::function<void(const cv::Mat&)> reset;
  std::function<std::optional<Measured>(const cv::Mat&)> measure;
};

/// Is the `reset` of methods that keep nothing between frames.
inline void nothing_to_reset(const cv::Mat& /*window*/) {}

/// Returns all methods: ours first, vpDot2's tracking second.
std::vector<CenterMethodUnderTest> center_methods();

/// Returns what the fit of our method leaves open.
FurtherUnknowns unknown_to_ours();

// These are the parts of center_methods().
std::vector<CenterMethodUnderTest> our_centers();
std::vector<CenterMethodUnderTest> visp_centers();
std::vector<CenterMethodUnderTest> opencv_centers();

/// Returns the lamp of a window, for methods that are told where it is.
Blob lamp_of(const cv::Mat& window);

}  // namespace planar::bench
