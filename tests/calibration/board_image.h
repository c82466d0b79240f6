#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar::test {

/// A camera of 640 x 480 pixels without distortion.
inline Pinhole small_camera() {
  return {{600.0, 590.0, 322.0, 236.0}};
}

/// The pose of a board whose middle stands `distance` before the camera, tilted about an axis in
/// the image at `axis` (radians), then turned about the line of sight.
inline Pose board_before_camera(const Board& board, double distance, double tilt, double axis,
                                double turn) {
  const Eigen::Vector3d middle(0.5 * (board.columns - 1) * board.pitch,
                               0.5 * (board.rows - 1) * board.pitch, 0.0);
  const Eigen::Vector3d tilt_axis(std::cos(axis), std::sin(axis), 0.0);
  Pose X_CG = Pose::Identity();
  X_CG.linear() = rotation_from_vector(tilt * tilt_axis) * rotation_from_vector({0.0, 0.0, turn});
  X_CG.translation() = Eigen::Vector3d(0.0, 0.0, distance) - X_CG.linear() * middle;
  return X_CG;
}

struct Ink {
  double dot{40.0};
  double paper{200.0};
};

/// Where rays of a camera meet a board of dots.
class BoardRays {
 public:
  BoardRays(const Board& board, const Pose& X_CG, int missing)
      : board_(board), X_GC_(X_CG.inverse()), missing_(missing) {}

  /// Returns where a normalised point of the image lies on the board.
  Eigen::Vector2d meet(const Eigen::Vector2d& xy) const {
    const Eigen::Vector3d ray_G = X_GC_.linear() * xy.homogeneous();
    const Eigen::Vector3d& eye = X_GC_.translation();
    return eye.head<2>() - eye.z() / ray_G.z() * ray_G.head<2>();
  }

  /// Returns how far a place lies from the centre of the dot that is nearest; for the dot that is
  /// missing infinity.
  double to_dot(const Eigen::Vector2d& p_G) const {
    const double column = std::clamp(std::round(p_G.x() / board_.pitch), 0.0, board_.columns - 1.0);
    const double row = std::clamp(std::round(p_G.y() / board_.pitch), 0.0, board_.rows - 1.0);
    if (static_cast<int>(row) * board_.columns + static_cast<int>(column) == missing_)
      return std::numeric_limits<double>::infinity();
    return std::hypot(p_G.x() - column * board_.pitch, p_G.y() - row * board_.pitch);
  }

 private:
  const Board& board_;
  Pose X_GC_;
  int missing_;
};

/// Picture of a dot board: every pixel at a rim the mean over 6 x 6 rays, so exact to a fraction of
/// a grey level; the lens is linear within a pixel. Dot `missing` (row by row) is left out.
inline cv::Mat picture_of_dots(const CameraModel& camera, const Board& board, double dot_diameter,
                               const Pose& X_CG, const Ink& ink = {}, int missing = -1) {
  constexpr int kSubdivision = 6;
  const BoardRays rays(board, X_CG, missing);
  const auto part_of_pixel = [&](int u, int v) {
    Eigen::Matrix2d d_xy_d_uv;
    const Eigen::Vector2d middle = ray(camera, {u, v}, &d_xy_d_uv).value().head<2>();
    const auto meet = [&](double a, double b) {
      return rays.meet(middle + d_xy_d_uv * Eigen::Vector2d(a, b));
    };
    const Eigen::Vector2d p_G = meet(0.0, 0.0);
    const double pixel = std::max((meet(0.5, 0.5) - p_G).norm(), (meet(0.5, -0.5) - p_G).norm());
    const double inside = 0.5 * dot_diameter - rays.to_dot(p_G);
    if (std::abs(inside) > 1.2 * pixel) return inside > 0.0 ? 1.0 : 0.0;
    int hits = 0;
    for (int a = 0; a < kSubdivision; ++a)
      for (int b = 0; b < kSubdivision; ++b)
        hits += rays.to_dot(meet((a + 0.5) / kSubdivision - 0.5, (b + 0.5) / kSubdivision - 0.5)) <
                        0.5 * dot_diameter
                    ? 1
                    : 0;
    return static_cast<double>(hits) / (kSubdivision * kSubdivision);
  };
  cv::Mat image(480, 640, CV_8UC1);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(ink.paper + part_of_pixel(u, v) * (ink.dot - ink.paper));
  return image;
}

}  // namespace planar::test
