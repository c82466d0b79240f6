#include "planar_servo/calibration/board_pose.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

namespace planar {
namespace {

std::optional<std::vector<cv::Point2d>> normalized(const CameraModel& camera,
                                                   const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2d> rays;
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray_C = ray(camera, pixel);
    if (!ray_C) return std::nullopt;
    rays.emplace_back(ray_C->x(), ray_C->y());
  }
  return rays;
}

std::optional<Pose> pose_of(const std::vector<cv::Point3d>& points,
                            const std::vector<cv::Point2d>& rays) {
  cv::Vec3d rotation, translation;
  const cv::Matx33d identity = cv::Matx33d::eye();
  try {
    if (!cv::solvePnP(points, rays, identity, cv::noArray(), rotation, translation, false,
                      cv::SOLVEPNP_ITERATIVE))
      return std::nullopt;
    cv::solvePnPRefineLM(points, rays, identity, cv::noArray(), rotation, translation);
  } catch (const cv::Exception&) {
    return std::nullopt;  // how OpenCV reports points on one line
  }
  Pose X_CG = Pose::Identity();
  X_CG.linear() = rotation_from_vector({rotation[0], rotation[1], rotation[2]});
  X_CG.translation() << translation[0], translation[1], translation[2];
  if (!X_CG.matrix().allFinite()) return std::nullopt;
  return X_CG;
}

}  // namespace

std::optional<BoardPose> estimate_board_pose(const CameraModel& camera,
                                             const std::vector<Eigen::Vector2d>& points_G,
                                             const std::vector<Eigen::Vector2d>& pixels) {
  if (points_G.size() != pixels.size())
    throw std::invalid_argument("estimate_board_pose: there must be as many pixels as points");
  if (pixels.size() < 4) return std::nullopt;
  const auto rays = normalized(camera, pixels);
  if (!rays) return std::nullopt;
  std::vector<cv::Point3d> points;
  points.reserve(points_G.size());
  for (const Eigen::Vector2d& p : points_G) points.emplace_back(p.x(), p.y(), 0.0);
  const auto X_CG = pose_of(points, *rays);
  if (!X_CG) return std::nullopt;
  const auto residuals = board_residuals(camera, *X_CG, points_G, pixels);
  if (!residuals) return std::nullopt;
  return BoardPose{*X_CG, rms_length(*residuals)};
}

std::optional<std::vector<Eigen::Vector2d>> board_residuals(
    const CameraModel& camera, const Pose& X_CG, const std::vector<Eigen::Vector2d>& points_G,
    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto pixel =
        project(camera, X_CG * Eigen::Vector3d(points_G[i].x(), points_G[i].y(), 0.0));
    if (!pixel) return std::nullopt;
    residuals.push_back(pixels[i] - *pixel);
  }
  return residuals;
}

double rms_length(const std::vector<Eigen::Vector2d>& residuals) {
  double squares = 0.0;
  for (const Eigen::Vector2d& residual : residuals) squares += residual.squaredNorm();
  return std::sqrt(squares / static_cast<double>(residuals.size()));
}

}  // namespace planar
