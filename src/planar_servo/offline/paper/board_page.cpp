#include "planar_servo/offline/paper/board_page.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/paper/page.h"

namespace planar {
namespace {

constexpr double kDotPitches = 0.4, kDotBorderPitches = 0.75;
constexpr double kSquareBorderPitches = 2.0;  // the outer squares and as much white
constexpr double kLeastPitch_mm = 1.0;        // that is proposed

double pitch_mm(const Board& board) {
  return mm(board.pitch);
}

/// Returns a dot's diameter or a square's side.
double mark_mm(const Board& board) {
  return pitch_mm(board) * (board.has_dots() ? kDotPitches : 1.0);
}

/// Returns the pitches from the outer points to the drawing's edge.
double border_pitches(const Board& board) {
  return board.has_dots() ? kDotBorderPitches : kSquareBorderPitches;
}

Eigen::Vector2d size_pitches(const Board& board) {
  return board_extent(board).array() + 2.0 * border_pitches(board);
}

std::string text_of(const std::string& words, const Board& board) {
  return fmt::format(
      "{}, {} of {:g} mm. Print at 100 %, not fitted to the page, and measure both rulers (mm). "
      "Glue the "
      "sheet to a flat plate. Then measure the pitch over the whole board and state it: "
      "planar-calibrate-camera --grid {}:PITCHmm",
      words, board.has_dots() ? "dots" : "squares", mark_mm(board),
      words.substr(0, words.rfind(':')));
}

/// Says which pitch and which counts the room allows.
std::string what_fits(const Board& board, const Eigen::Vector2d& room_mm) {
  std::string text;
  const double pitch = (room_mm.array() / size_pitches(board).array()).minCoeff();
  if (pitch >= kLeastPitch_mm)
    text +=
        fmt::format("the largest pitch that fits is {:g} mm; ", std::floor(10.0 * pitch) / 10.0);
  const Eigen::Vector2d pitches =
      (room_mm / pitch_mm(board)).array() - (2.0 * border_pitches(board) - 1.0);
  const double per_column = board.kind == Board::Kind::kAsymmetricCircles ? 2.0 : 1.0;
  const int columns =
      std::min(board.columns, static_cast<int>(std::floor(pitches.x() / per_column)));
  const int rows = std::min(board.rows, static_cast<int>(std::floor(pitches.y())));
  if (columns >= 3 && rows >= 3)
    text +=
        fmt::format("the largest count at {:g} mm is {} x {}; ", pitch_mm(board), columns, rows);
  return text;
}

void draw_dots(Pen& pen, const BoardPage& drawn) {
  for (const Eigen::Vector2d& p : board_points(drawn.board))
    pen.disc(drawn.first_point_mm + p / kMillimetre, drawn.mark_mm);
}

void draw_squares(Pen& pen, const BoardPage& drawn) {
  const Eigen::Vector2d first = drawn.first_point_mm - Eigen::Vector2d::Constant(drawn.mark_mm);
  for (int row = 0; row <= drawn.board.rows; ++row)
    for (int column = row % 2; column <= drawn.board.columns; column += 2)
      pen.square(first + drawn.mark_mm * Eigen::Vector2d(column, row), drawn.mark_mm);
}

}  // namespace

BoardPage board_page(const std::string& words, const std::string& page) {
  BoardPage drawn;
  drawn.board = parse_board(words);
  const Board& board = drawn.board;
  const Eigen::Vector2d size_mm = pitch_mm(board) * size_pitches(board);
  const RuledPage ruled(stated_page_mm(page, size_mm.x() > size_mm.y()), size_mm,
                        text_of(words, board));
  ruled.require_room(size_mm, words, what_fits(board, ruled.room_mm()));
  drawn.first_point_mm = ruled.corner_of(size_mm).array() + pitch_mm(board) * border_pitches(board);
  drawn.mark_mm = mark_mm(board);
  drawn.rulers_mm = ruled.rulers_mm();
  drawn.page.size_mm = ruled.page_mm();
  drawn.page.draw = [drawn, ruled](Pen& pen) {
    drawn.board.has_dots() ? draw_dots(pen, drawn) : draw_squares(pen, drawn);
    ruled.draw(pen);
  };
  return drawn;
}

ReportList board_page_list(const BoardPage& drawn) {
  const bool dots = drawn.board.has_dots();
  ReportList list;
  list.line("page", "{page_mm:g| x } mm", Eigen::Vector2d(drawn.page.size_mm * kMillimetre));
  list.line("board",
            fmt::format("{} x {} {}, {{pitch_mm:g}} mm apart", drawn.board.columns,
                        drawn.board.rows, dots ? "dots" : "inner corners"),
            drawn.board.pitch);
  list.line(dots ? "dots" : "squares", "{mark_mm:g} mm wide", drawn.mark_mm * kMillimetre);
  list.line("rulers", "{ruler_mm:g| and } mm", Eigen::Vector2d(drawn.rulers_mm * kMillimetre));
  return list;
}

}  // namespace planar
