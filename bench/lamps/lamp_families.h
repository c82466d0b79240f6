#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "support/rendered_lamp.h"

namespace planar::bench {

/// Holds one drawn lamp.
struct LampSample {
  cv::Mat scene;  ///< CV_32F, noise-free
  Eigen::Vector2d center_px;
  std::optional<test::RenderedLamp> clean;  ///< the same lamp when it has no defect
};

/// Lamps of one kind, drawn at random.
struct LampFamily {
  std::string name;
  std::function<LampSample(std::mt19937&)> draw;
};

/// The side of every window, and the level round a lamp.
constexpr int kWindowSide_px = 128;
constexpr double kBackground = 12.0;

/// Returns clean lamps and the defects of bench/lamps/README.md.
std::vector<LampFamily> lamp_families();

}  // namespace planar::bench
