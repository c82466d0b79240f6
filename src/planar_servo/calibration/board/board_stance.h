#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "planar_servo/calibration/board/board.h"

namespace planar {

/// The corners of a picture, clockwise.
enum class PictureCorner { kUpperLeft, kUpperRight, kLowerRight, kLowerLeft };
constexpr std::array<PictureCorner, 4> kPictureCorners{
    PictureCorner::kUpperLeft, PictureCorner::kUpperRight, PictureCorner::kLowerRight,
    PictureCorner::kLowerLeft};

/// Returns the corner of a picture of this size, a sixth of each side.
cv::Rect2d corner_of_picture(PictureCorner corner, const cv::Size& picture_px);

/// Describes how a board stands in a picture, as far as a camera tells that nobody has calibrated.
/// Directions are the picture's, x right and y down.
struct BoardStance {
  Eigen::Vector2d middle{0.0, 0.0};      ///< of the board, as shares of the picture's sides
  double size{0.0};                      ///< root of the share of the picture that it covers
  Eigen::Vector2d tilt{0.0, 0.0};        ///< radians, towards the edge that is nearer to the camera
  double turn{0.0};                      ///< radians, from the picture's rows to the board's
  double turn_period{0.0};               ///< radians, after which the board looks the same
  std::array<bool, 4> reaches_corner{};  ///< by PictureCorner: a dot lies in it

  bool reaches(PictureCorner corner) const {
    return reaches_corner[static_cast<std::size_t>(corner)];
  }
};

/// Estimates the stance of a board from its points in a picture of this size, by the homography
/// from the board. The gradient of the inverse depth over the picture, which is that of a plane
/// [Hartley and Zisserman 2004, 8.1], gives the tilt against the image plane, as it is under a lens
/// whose focal length is 1.5 times the picture's longer side; the lens's distortion counts as
/// tilt, so that 10 degrees more or less mean nothing. Empty without points, and when they lie on a
/// line.
std::optional<BoardStance> board_stance(const Board& board,
                                        const std::vector<Eigen::Vector2d>& pixels,
                                        const cv::Size& picture_px);

/// Returns the angle in (-period/2, period/2] that differs from `angle` by whole periods.
double wrap_to_period(double angle, double period);

}  // namespace planar
