#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

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

/// Ours first, vpDot2's tracking second.
std::vector<CenterMethodUnderTest> center_methods();

}  // namespace planar::bench
