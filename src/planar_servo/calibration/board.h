#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

/// Describes a flat calibration board. Its frame G has x along a row, y along a column and z away
/// from the camera; point (column, row) lies at (column, row, 0) * pitch.
struct Board {
  enum class Kind { kCircles, kChessboard };
  Kind kind{Kind::kCircles};
  int columns{0};  ///< of dots, or of the chessboard's inner corners
  int rows{0};
  double pitch{0.0};  ///< metres
  bool pitch_known{true};
};

/// What a board is used for: to give lengths by its pitch, or only its shape; the pitch may then be
/// unknown.
enum class BoardUse { kLengths, kShape };

/// Reads `circles:COLSxROWS:PITCHmm` or `chessboard:COLSxROWS:PITCHmm`, with `?` for an unknown
/// pitch, which then counts as 1 mm. Throws InputError unless both counts are at least 3 and the
/// pitch is positive, and when lengths are needed but the pitch is unknown.
Board parse_board(const std::string& text, BoardUse use = BoardUse::kLengths);

/// Returns the board's points in G (metres), row by row, as find_board() orders them.
std::vector<Eigen::Vector2d> board_points(const Board& board);

/// What an image shows of a board: all its points, row by row, or why it was not found.
struct BoardSight {
  std::vector<Eigen::Vector2d> pixels;  ///< centres of dots or corners
  std::vector<double> dot_areas_px2;    ///< of each dot's ellipse; empty for a chessboard
  std::vector<double> dot_sigmas_px;    ///< of each dot's centre; empty for a chessboard
  std::string reason;                   ///< why the board was not found
  std::size_t dots_in_a_grid{0};        ///< of the largest grid, if the board was not found

  bool found() const { return !pixels.empty(); }
};

/// Finds the board in an 8-bit grey image without any hint. The whole board must be in view. The
/// order of the points is never mirrored; of a board that looks the same when turned, the x axis is
/// the one that points most to the right. Throws std::invalid_argument for an image that is not
/// CV_8UC1.
BoardSight find_board(const cv::Mat& image, const Board& board);

/// Finds the board as find_board() does, but in a reduced image and much faster, to follow a board
/// that is being moved. Returns pixels of `image`.
BoardSight glance_at_board(const cv::Mat& image, const Board& board);

struct BoardPose {
  Pose X_CG{Pose::Identity()};
  double rms_px{0.0};  ///< root of the mean square distance from seen to projected points
};

/// Estimates the pose of a flat board (points in its plane z_G = 0, metres) from the pixels of its
/// points. It solves the perspective-n-point problem on undistorted rays, then refines the pose by
/// least squares on them. Empty with fewer than 4 points, when a pixel has no ray, or when the
/// points do not determine a pose in front of the camera. Throws std::invalid_argument when there
/// are not as many pixels as points.
std::optional<BoardPose> estimate_board_pose(const CameraModel& camera,
                                             const std::vector<Eigen::Vector2d>& points_G,
                                             const std::vector<Eigen::Vector2d>& pixels);

/// Returns the seen minus the projected pixel of each point. Empty when a point has no projection.
std::optional<std::vector<Eigen::Vector2d>> board_residuals(
    const CameraModel& camera, const Pose& X_CG, const std::vector<Eigen::Vector2d>& points_G,
    const std::vector<Eigen::Vector2d>& pixels);

/// Returns the root of the mean square length of the residuals.
double rms_length(const std::vector<Eigen::Vector2d>& residuals);

}  // namespace planar
