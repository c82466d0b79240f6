#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

/// Describes a flat calibration board. Its frame G has x along a row, y along a column and z away
/// from the camera; point (column, row) lies at (column, row, 0) * pitch. In an asymmetric grid
/// every second row of dots is shifted by one pitch, and the dots of a row are two pitches apart.
struct Board {
  enum class Kind { kCircles, kAsymmetricCircles, kChessboard };
  Kind kind{Kind::kCircles};
  int columns{0};  ///< dots in a row, or inner corners of the chessboard
  int rows{0};
  double pitch{0.0};  ///< metres
  bool pitch_known{true};

  bool has_dots() const { return kind != Kind::kChessboard; }
  std::size_t points() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

/// The kinds of boards, as the words of a board begin.
constexpr Named<Board::Kind> kBoardKinds[] = {{Board::Kind::kCircles, "circles"},
                                              {Board::Kind::kAsymmetricCircles, "acircles"},
                                              {Board::Kind::kChessboard, "chessboard"}};

/// What a board is used for: to give lengths by its pitch, or only its shape; the pitch may then be
/// unknown.
enum class BoardUse { kLengths, kShape };

/// Reads `circles:COLSxROWS:PITCHmm`, `acircles:...` or `chessboard:...`, with `?` for an unknown
/// pitch, which then counts as 1 mm. Throws InputError unless both counts are at least 3 and the
/// pitch is positive, and when lengths are needed but the pitch is unknown.
Board parse_board(const std::string& text, BoardUse use = BoardUse::kLengths);

/// Returns the board's places in steps of its pitch, (column, row) of a plain grid, row by row.
std::vector<Eigen::Vector2i> board_places(const Board& board);
/// Returns the largest x and y among them.
Eigen::Vector2d board_extent(const Board& board);

/// Returns the board's points in G (metres), row by row, as find_board() orders them.
std::vector<Eigen::Vector2d> board_points(const Board& board);

/// What an image shows of a board: its points, row by row, or why it was not found.
struct BoardSight {
  std::vector<Eigen::Vector2d> pixels;  ///< centres of dots or corners
  std::vector<double> dot_areas_px2;    ///< of each dot's ellipse; empty for a chessboard
  std::vector<double> dot_sigmas_px;    ///< of each dot's centre; empty for a chessboard
  std::string reason;                   ///< why the board was not found
  std::size_t dots_in_a_grid{0};        ///< of the largest grid, if the board was not found
  std::vector<std::size_t> seen{};      ///< indices of the points seen; empty where all are

  bool found() const { return !pixels.empty(); }
};

/// Returns those of the board's points that are seen, in the order of the sight's pixels.
std::vector<Eigen::Vector2d> seen_points(const Board& board, const BoardSight& sight);

/// How much of a board of dots must be seen: all, or half of its dots and at least one in every
/// outer row and column.
enum class BoardPart { kWhole, kMost };

/// Finds the board in an 8-bit grey image without any hint. The whole board must be in view. The
/// order of the points is never mirrored; of a board that looks the same when turned, the x axis is
/// the one that points most to the right. Throws std::invalid_argument for an image that is not
/// CV_8UC1.
BoardSight find_board(const cv::Mat& image, const Board& board, BoardPart part = BoardPart::kWhole);

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

/// Returns the points as seen from their centroid.
std::vector<Eigen::Vector2d> about_centroid(std::vector<Eigen::Vector2d> points);

/// Returns the root of the mean square length of the residuals.
double rms_length(const std::vector<Eigen::Vector2d>& residuals);

}  // namespace planar
