#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <random>

namespace planar::bench {

enum class GradientKind { kLinear, kQuadratic, kRadial };

/// A lamp on a dark background whose light, surroundings and outline need not be perfect. Grey
/// levels; pixels; angles from u to v.
struct DefectiveLamp {
  Eigen::Vector2d center_px{0.0, 0.0};
  double diameter_px{40.0};
  double axis_ratio{1.0};
  double direction_rad{0.0};  ///< of the major axis
  double blur_px{0.85};       ///< standard deviation
  double background{12.0};
  double amplitude{180.0};

  double gradient{0.0};  ///< share of the amplitude from the middle to the rim
  GradientKind gradient_kind{GradientKind::kLinear};
  double gradient_direction_rad{0.0};

  double halo{0.0};  ///< share of the amplitude, at the rim, on the side of its direction
  double halo_decay_px{5.0};
  double halo_direction_rad{0.0};

  /// Radius over that of the ellipse, less 1: cosine and sine parts of the harmonics 2 to 9.
  std::array<Eigen::Vector2d, 8> rim{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};

  double cut{2.0};  ///< distance of a straight cut from the centre over the radius; 2: none
  double cut_direction_rad{0.0};
};

/// Harmonics of equal expected power, scaled to this rms over the rim.
void draw_rim(DefectiveLamp& lamp, double rms, std::mt19937& random);

/// The noise-free image, CV_32F: the scene, blurred, summed into pixels.
cv::Mat render(const DefectiveLamp& lamp, const cv::Size& size);

}  // namespace planar::bench
