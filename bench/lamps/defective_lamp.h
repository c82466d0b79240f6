#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <random>

namespace planar::bench {

/// Says how the level changes across the lamp.
enum class GradientKind { kLinear, kQuadratic, kRadial };

/// A lamp on a dark background whose light, surroundings and outline need not be perfect. Levels
/// are grey levels; angles turn from u to v.
struct DefectiveLamp {
  Eigen::Vector2d center_px{0.0, 0.0};
  double diameter_px{40.0};
  double axis_ratio{1.0};
  double direction_rad{0.0};  ///< direction of the major axis
  double blur_px{0.85};       ///< standard deviation
  double background{12.0};
  double amplitude{180.0};

  /// The change of level from the middle to the rim, as a share of the amplitude.
  double gradient{0.0};
  GradientKind gradient_kind{GradientKind::kLinear};
  double gradient_direction_rad{0.0};

  double halo{0.0};  ///< level at the rim on the side of its direction, as a share of the amplitude
  double halo_decay_px{5.0};
  double halo_direction_rad{0.0};

  /// The radius over that of the ellipse, minus 1: cosine and sine parts of the harmonics 2 to 9.
  std::array<Eigen::Vector2d, 8> rim{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};

  double cut{2.0};  ///< distance of a straight cut from the centre over the radius; 2 for none
  double cut_direction_rad{0.0};
};

/// Draws harmonics of equal expected power and scales them to this rms over the rim.
void draw_rim(DefectiveLamp& lamp, double rms, std::mt19937& random);

/// Renders the noise-free image (CV_32F): the scene is blurred and summed into pixels.
cv::Mat render(const DefectiveLamp& lamp, const cv::Size& size);

}  // namespace planar::bench
