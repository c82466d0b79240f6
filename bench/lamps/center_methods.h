#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lamps/cramer_rao.h"
#include "planar_servo/lamps/detect/blob.h"

namespace planar::bench {

struct Measured {
  Eigen::Vector2d uv_px;
  std::optional<Eigen::Matrix2d> covariance_px2;  ///< of the methods that state one
};

/// A way to measure the one lamp of a window; empty when it finds none. `reset` brings what follows
/// lamps from frame to frame back to this frame, and is not timed.
struct CenterMethodUnderTest {
  std::string name;
  std::function<void(const cv::Mat&)> reset;
  std::function<std::optional<Measured>(const cv::Mat&)> measure;
};

inline void nothing_to_reset(const cv::Mat& /*window*/) {}

/// Ours first, vpDot2's tracking second.
std::vector<CenterMethodUnderTest> center_methods();

/// What the fit of our method leaves open.
FurtherUnknowns unknown_to_ours();

// The parts of center_methods().
std::vector<CenterMethodUnderTest> our_centers();
std::vector<CenterMethodUnderTest> visp_centers();
std::vector<CenterMethodUnderTest> opencv_centers();

/// The lamp of a window, for those who are told where it is.
Blob lamp_of(const cv::Mat& window);

}  // namespace planar::bench
