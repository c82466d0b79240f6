#pragma once

#include <random>
#include <string>

#include "calibration/board_image.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar::test {

inline const Board kBoard{Board::Kind::kCircles, 9, 7, 0.03};
inline constexpr Intrinsics kIntrinsics{1400.0, 1390.0, 650.0, 500.0};
inline constexpr double kNoise_px = 0.05;

/// The board at X_CG as `camera` sees it, with normal noise on each coordinate, as the centres of
/// the images of round dots when they have a diameter.
inline CalibrationView view_of_board(const CameraModel& camera, const Pose& X_CG,
                                     const std::string& name, std::mt19937& random,
                                     double dot_diameter = 0.0, double noise_px = kNoise_px) {
  std::normal_distribution<double> noise(0.0, noise_px);
  CalibrationView view{name, board_points(kBoard), {}, {}};
  for (const Eigen::Vector2d& p : view.points_G) {
    const Eigen::Vector3d p_C = X_CG * Eigen::Vector3d(p.x(), p.y(), 0.0);
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    Eigen::Vector2d uv = project(camera, p_C, &d_uv_d_p).value();
    if (dot_diameter > 0.0) {
      uv += eccentricity_px(camera, X_CG, p, dot_diameter).value();
      const Eigen::Matrix2d J = d_uv_d_p * X_CG.linear().leftCols<2>();
      const double determinant = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
      view.dot_areas_px2.push_back(std::abs(determinant) * 3.14159265 * dot_diameter *
                                   dot_diameter / 4.0);
    }
    for (double& coordinate : uv) coordinate += noise(random);
    view.pixels.push_back(uv);
  }
  return view;
}

/// Of an image of 1300 x 1000 pixels.
inline CalibrationProblem problem_of(const std::string& model) {
  CalibrationProblem problem;
  problem.width_px = 1300;
  problem.height_px = 1000;
  problem.model = model;
  return problem;
}

/// The pose of the board in view `i`: tilted to another side in each.
inline Pose pose_of_view(int i) {
  return board_before_camera(kBoard, 0.38 + 0.02 * (i % 3), 0.25 + 0.05 * (i % 5), 1.3 * i,
                             0.2 * i);
}

inline CalibrationProblem views_of_board(const CameraModel& camera, int count,
                                         const std::string& model, double dot_diameter = 0.0,
                                         double noise_px = kNoise_px, unsigned seed = 7) {
  std::mt19937 random(seed);
  CalibrationProblem problem = problem_of(model);
  for (int i = 0; i < count; ++i) {
    problem.views.push_back(view_of_board(camera, pose_of_view(i), "view" + std::to_string(i),
                                          random, dot_diameter, noise_px));
  }
  return problem;
}

}  // namespace planar::test
