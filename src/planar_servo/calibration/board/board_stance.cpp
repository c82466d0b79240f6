#include "planar_servo/calibration/board/board_stance.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// The focal length of a usual lens over the picture's longer side.
constexpr double kUsualFocal = 1.5;
constexpr double kCornerShare = 1.0 / 6.0;

/// Returns the homography from (column, row) to pixels.
std::optional<Eigen::Matrix3d> board_homography(const Board& board,
                                                const std::vector<Eigen::Vector2d>& pixels) {
  if (pixels.size() < 4) return std::nullopt;
  std::vector<cv::Point2d> from, to;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto column = static_cast<int>(i) % board.columns;
    from.emplace_back(column, (static_cast<int>(i) - column) / board.columns);
    to.emplace_back(pixels[i].x(), pixels[i].y());
  }
  const cv::Mat found = cv::findHomography(from, to);
  if (found.empty()) return std::nullopt;
  Eigen::Matrix3d H;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) H(row, column) = found.at<double>(row, column);
  if (!H.allFinite() || std::abs(H.determinant()) < 1e-12) return std::nullopt;
  return H;
}

bool is_reached(PictureCorner corner, const std::vector<Eigen::Vector2d>& pixels,
                const cv::Size& picture_px) {
  const cv::Rect2d place = corner_of_picture(corner, picture_px);
  return std::any_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& pixel) {
    return place.contains(cv::Point2d(pixel.x() + 0.5, pixel.y() + 0.5));
  });
}

Eigen::Vector2d tilt_seen(const Eigen::Matrix3d& H, const Eigen::Vector2d& middle_px,
                          const cv::Size& picture_px) {
  // The third row of the inverse is, but for a factor, the inverse depth as a function of pixels.
  const Eigen::RowVector3d inverse_depth = H.inverse().row(2);
  const Eigen::Vector2d growth =
      inverse_depth.head<2>().transpose() / (inverse_depth * middle_px.homogeneous()).value();
  if (growth.norm() == 0.0) return {0.0, 0.0};
  const double focal_px = kUsualFocal * std::max(picture_px.width, picture_px.height);
  return std::atan(focal_px * growth.norm()) * growth.normalized();
}

}  // namespace

cv::Rect2d corner_of_picture(PictureCorner corner, const cv::Size& picture_px) {
  const cv::Point2d size = kCornerShare * cv::Point2d(picture_px.width, picture_px.height);
  const bool right = corner == PictureCorner::kUpperRight || corner == PictureCorner::kLowerRight;
  const bool lower = corner == PictureCorner::kLowerRight || corner == PictureCorner::kLowerLeft;
  return {right ? picture_px.width - size.x : 0.0, lower ? picture_px.height - size.y : 0.0, size.x,
          size.y};
}

double wrap_to_period(double angle, double period) {
  return angle - period * std::ceil(angle / period - 0.5);
}

std::optional<BoardStance> board_stance(const Board& board,
                                        const std::vector<Eigen::Vector2d>& pixels,
                                        const cv::Size& picture_px) {
  const auto H = board_homography(board, pixels);
  if (!H) return std::nullopt;
  const Eigen::Vector3d middle =
      *H * Eigen::Vector3d(0.5 * (board.columns - 1), 0.5 * (board.rows - 1), 1.0);
  const Eigen::Vector2d middle_px = middle.hnormalized();
  const Eigen::Matrix2d pixels_per_pitch =
      (H->topLeftCorner<2, 2>() - middle_px * H->bottomLeftCorner<1, 2>()) / middle.z();
  const double area_px2 =
      std::abs(pixels_per_pitch.determinant()) * (board.columns - 1) * (board.rows - 1);
  BoardStance stance;
  stance.middle = (middle_px.array() + 0.5) / Eigen::Array2d(picture_px.width, picture_px.height);
  stance.size = std::sqrt(area_px2 / picture_px.area());
  stance.tilt = tilt_seen(*H, middle_px, picture_px);
  stance.turn_period = board.columns == board.rows ? kPi / 2.0 : kPi;
  stance.turn = wrap_to_period(std::atan2(pixels_per_pitch(1, 0), pixels_per_pitch(0, 0)),
                               stance.turn_period);
  for (const PictureCorner corner : kPictureCorners)
    stance.reaches_corner[static_cast<std::size_t>(corner)] =
        is_reached(corner, pixels, picture_px);
  return stance;
}

}  // namespace planar
