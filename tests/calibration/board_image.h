#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "planar_servo/calibration/board.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/lens/lens_models.h"

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

/// Picture of a dot board: every pixel the mean over 6 x 6 rays, so exact to a fraction of a grey
/// level at the dots' rims; the lens is linear within a pixel. Dot `missing` (row by row) is left
/// out.
inline cv::Mat picture_of_dots(const CameraModel& camera, const Board& board, double dot_diameter,
                               const Pose& X_CG, const Ink& ink = {}, int missing = -1) {
  constexpr int kSubdivision = 6;
  const Pose X_GC = X_CG.inverse();
  const auto covered = [&](const Eigen::Vector2d& xy) {
    const Eigen::Vector3d ray_G = X_GC.linear() * xy.homogeneous();
    const Eigen::Vector3d& eye = X_GC.translation();
    const double x = eye.x() - eye.z() * ray_G.x() / ray_G.z();
    const double y = eye.y() - eye.z() * ray_G.y() / ray_G.z();
    const double column = std::round(x / board.pitch);
    const double row = std::round(y / board.pitch);
    if (column < 0 || row < 0 || column >= board.columns || row >= board.rows) return false;
    if (static_cast<int>(row) * board.columns + static_cast<int>(column) == missing) return false;
    return std::hypot(x - column * board.pitch, y - row * board.pitch) < 0.5 * dot_diameter;
  };
  cv::Mat image(480, 640, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      Eigen::Matrix2d d_xy_d_uv;
      const Eigen::Vector3d middle = ray(camera, {u, v}, &d_xy_d_uv).value();
      int hits = 0;
      for (int a = 0; a < kSubdivision; ++a) {
        for (int b = 0; b < kSubdivision; ++b) {
          const Eigen::Vector2d at((a + 0.5) / kSubdivision - 0.5, (b + 0.5) / kSubdivision - 0.5);
          hits += covered(middle.head<2>() + d_xy_d_uv * at) ? 1 : 0;
        }
      }
      const double part = static_cast<double>(hits) / (kSubdivision * kSubdivision);
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(ink.paper + part * (ink.dot - ink.paper));
    }
  }
  return image;
}

}  // namespace planar::test
