#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

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

/// Says whether lengths are taken from a board's pitch. Where only its shape counts, the pitch may
/// be unknown.
enum class BoardUse { kLengths, kShape };

/// Reads `circles:COLSxROWS:PITCHmm` or `chessboard:COLSxROWS:PITCHmm`, with `?` for a pitch that
/// is not known; the board then has one of 1 mm. Throws InputError unless both counts are at least
/// 3 and the pitch is positive, and for an unknown one of which lengths are taken.
Board parse_board(const std::string& text, BoardUse use = BoardUse::kLengths);

/// Returns the board's points in G (metres), row by row, as find_board() orders them.
std::vector<Eigen::Vector2d> board_points(const Board& board);

/// Holds what an image shows of a board: every point of it, row by row, or the reason why it was
/// not found.
struct BoardSight {
  std::vector<Eigen::Vector2d> pixels;  ///< centres of dots or corners
  std::vector<double> dot_areas_px2;    ///< of each dot's ellipse; empty for a chessboard
  std::vector<double> dot_sigmas_px;    ///< of each dot's centre; empty for a chessboard
  std::string reason;                   ///< why the board was not found
  std::size_t dots_in_a_grid{0};        ///< where it was not found, of the largest grid seen

  bool found() const { return !pixels.empty(); }
};

/// Finds the board in an 8-bit grey image without any hint. Only the whole board counts. The order
/// of the points is never mirrored, but a board that looks the same when turned is taken with its x
/// axis most to the right. Throws std::invalid_argument for an image that is not CV_8UC1.
BoardSight find_board(const cv::Mat& image, const Board& board);

/// Finds the board like find_board(), but in a reduced image, in a small part of the time: to
/// follow a board that is moved. The pixels are those of `image`.
BoardSight glance_at_board(const cv::Mat& image, const Board& board);

}  // namespace planar
