#include "planar_servo/offline/paper/drawings.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kDotPitches = 0.4, kDotBorderPitches = 0.75;
constexpr double kSquareBorderPitches = 2.0;  // the outer squares and as much white
constexpr double kLeastPitch_mm = 1.0;        // that is proposed

/// Returns a dot's diameter or a square's side.
double mark_mm(const Board& board) {
  return mm(board.pitch) * (board.has_dots() ? kDotPitches : 1.0);
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
      "Glue the sheet to a flat plate. Then measure the pitch over the whole board and state it: "
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
      (room_mm / mm(board.pitch)).array() - (2.0 * border_pitches(board) - 1.0);
  const double per_column = board.kind == Board::Kind::kAsymmetricCircles ? 2.0 : 1.0;
  const int columns =
      std::min(board.columns, static_cast<int>(std::floor(pitches.x() / per_column)));
  const int rows = std::min(board.rows, static_cast<int>(std::floor(pitches.y())));
  if (columns >= 3 && rows >= 3)
    text +=
        fmt::format("the largest count at {:g} mm is {} x {}; ", mm(board.pitch), columns, rows);
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

using Eigen::Vector2d;

/// For dimensions and names, mm: left and below, right and above the parts.
const Vector2d kBefore(26.0, 14.0), kBehind(26.0, 20.0);
constexpr double kFirstDimension_mm = 7.0, kNextDimension_mm = 14.0;  // beyond the parts
constexpr double kOverhang_mm = 1.5;  // of a line beyond what it leads to
constexpr double kArrow_mm = 16.0;    // from lamp 2 along the tool's direction
constexpr double kEndPoint_mm = 2.0;  // diameter of its mark
constexpr char kText[] =
    "The tool seen from above, where the camera is. Print at 100 %, not fitted to the page, and "
    "measure both rulers (mm). Prick the centres through the paper into the tool's plate. The end "
    "point is the axis of joint 3; the arrow is the tool's direction phi.";

/// A round part; lengths in millimetres, places in the frame T.
struct Part {
  std::string name;
  Vector2d center;
  double diameter;
};

std::array<Part, 3> parts_of(const ToolMount& mount) {
  const Vector2d half(0.5 * mm(mount.lamps.separation_m), 0.0);
  return {Part{"lamp 1", -half, mm(mount.lamps.diameters_m[0])},
          Part{"lamp 2", half, mm(mount.lamps.diameters_m[1])},
          Part{"reflector", mount.p_TS / kMillimetre, mm(mount.ball_diameter)}};
}

void require_apart(const Part& a, const Part& b) {
  const double least_mm = 0.5 * (a.diameter + b.diameter);
  const double apart_mm = (a.center - b.center).norm();
  if (apart_mm >= least_mm) return;
  throw InputError(
      {fmt::format("{} and {} overlap: their centres are {:.1f} mm apart", a.name, b.name,
                   apart_mm),
       fmt::format(
           "place them at least {:.1f} mm apart, by `lamps` of the cell file, --reflector-mm "
           "or --ball-mm",
           least_mm),
       "", Cause::kContradiction});
}

/// Draws in the tool's frame T, y up.
class ToolPen {
 public:
  ToolPen(Pen& pen, Vector2d origin_mm) : pen_(pen), origin_mm_(std::move(origin_mm)) {}

  void circle(const Vector2d& p, double diameter) { pen_.circle(on_page(p), diameter); }
  void line(const Vector2d& from, const Vector2d& to) { pen_.line(on_page(from), on_page(to)); }
  void arrow(const Vector2d& from, const Vector2d& to) { pen_.arrow(on_page(from), on_page(to)); }
  void text(const Vector2d& p, const std::string& words, Pen::Align align = Pen::Align::kLeft) {
    pen_.text(on_page(p), words, align);
  }
  /// Writes the distance of two places on one height beside a line with two arrow heads.
  void dimension(const Vector2d& from, const Vector2d& to) {
    const Vector2d middle = 0.5 * (from + to);
    arrow(middle, from);
    arrow(middle, to);
    text(middle + Vector2d(1.0, 1.0), fmt::format("{:g}", (to - from).norm()));
  }

 private:
  Vector2d on_page(const Vector2d& p) const { return origin_mm_ + Vector2d(p.x(), -p.y()); }

  Pen& pen_;
  Vector2d origin_mm_;
};

/// The rectangle around the parts, in T.
struct Extent {
  Vector2d low, high;

  explicit Extent(const std::array<Part, 3>& parts) : low(parts[0].center), high(low) {
    for (const Part& part : parts) {
      low = low.cwiseMin(Vector2d(part.center.array() - 0.5 * part.diameter));
      high = high.cwiseMax(Vector2d(part.center.array() + 0.5 * part.diameter));
    }
  }
  Vector2d drawing_mm() const { return high - low + kBefore + kBehind; }
};

void draw_parts(ToolPen& pen, const std::array<Part, 3>& parts) {
  for (const Part& part : parts) {
    pen.circle(part.center, part.diameter);
    const double reach = 0.5 * part.diameter + kOverhang_mm;
    pen.line(part.center - Vector2d(reach, 0.0), part.center + Vector2d(reach, 0.0));
    pen.line(part.center - Vector2d(0.0, reach), part.center + Vector2d(0.0, reach));
    const std::string words = fmt::format("{}, Ø {:g} mm", part.name, part.diameter);
    const double aside = 0.36 * part.diameter + kOverhang_mm;
    if (&part == &parts[2])
      pen.text(part.center + Vector2d(aside, -aside - kTextHeight_mm), words);
    else if (&part == &parts[1])
      pen.text(part.center + Vector2d(aside, aside), words);
    else
      pen.text(part.center + Vector2d(-aside, aside), words, Pen::Align::kRight);
  }
}

void draw_dimensions(ToolPen& pen, const std::array<Part, 3>& parts, const Extent& extent) {
  const double near_y = extent.high.y() + kFirstDimension_mm;
  const double far_y = extent.high.y() + kNextDimension_mm;
  const Vector2d lamp1 = parts[0].center, lamp2 = parts[1].center, reflector = parts[2].center;
  for (const double x : {lamp1.x(), 0.0, lamp2.x()})
    pen.line({x, 0.0}, {x, (x == 0.0 ? near_y : far_y) + kOverhang_mm});
  pen.dimension({0.0, near_y}, {lamp2.x(), near_y});
  pen.dimension({lamp1.x(), far_y}, {lamp2.x(), far_y});
  if (reflector.x() != 0.0) {
    const double y = extent.low.y() - kFirstDimension_mm;
    pen.line({0.0, 0.0}, {0.0, y - kOverhang_mm});
    pen.line(reflector, {reflector.x(), y - kOverhang_mm});
    pen.dimension({0.0, y}, {reflector.x(), y});
  }
  if (reflector.y() != 0.0) {
    const double x = extent.low.x() - kFirstDimension_mm;
    pen.line(lamp1, {x - kOverhang_mm, 0.0});
    pen.line(reflector, {x - kOverhang_mm, reflector.y()});
    pen.dimension({x, 0.0}, {x, reflector.y()});
  }
}

void draw_direction(ToolPen& pen, const std::array<Part, 3>& parts) {
  pen.circle({0.0, 0.0}, kEndPoint_mm);
  pen.text({kOverhang_mm, kOverhang_mm}, "end point");
  const Vector2d tip = parts[1].center + Vector2d(0.5 * parts[1].diameter + kArrow_mm, 0.0);
  pen.arrow(parts[0].center, tip);
  pen.text(tip + Vector2d(0.0, -kTextHeight_mm - 1.0), "phi", Pen::Align::kRight);
}

}  // namespace

BoardPage board_page(const std::string& words, const std::string& page) {
  BoardPage drawn;
  drawn.board = parse_board(words);
  const Board& board = drawn.board;
  const Eigen::Vector2d size_mm = mm(board.pitch) * size_pitches(board);
  const RuledPage ruled(stated_page_mm(page, size_mm.x() > size_mm.y()), size_mm,
                        text_of(words, board));
  ruled.require_room(size_mm, words, what_fits(board, ruled.room_mm()));
  drawn.first_point_mm = ruled.corner_of(size_mm).array() + mm(board.pitch) * border_pitches(board);
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

ToolPage tool_page(const ToolMount& mount, const std::string& page) {
  const std::array<Part, 3> parts = parts_of(mount);
  for (const auto& [a, b] : {std::pair(0, 1), {0, 2}, {1, 2}}) require_apart(parts[a], parts[b]);
  const Extent extent(parts);
  const Vector2d size_mm = extent.drawing_mm();
  const RuledPage ruled(stated_page_mm(page, size_mm.x() > size_mm.y()), size_mm, kText);
  ruled.require_room(size_mm, "the tool");
  const Vector2d corner = ruled.corner_of(size_mm);
  const Vector2d origin(corner.x() + kBefore.x() - extent.low.x(),
                        corner.y() + kBehind.y() + extent.high.y());
  const auto draw = [=](Pen& pen) {
    ToolPen tool(pen, origin);
    draw_parts(tool, parts);
    draw_dimensions(tool, parts, extent);
    draw_direction(tool, parts);
    ruled.draw(pen);
  };
  return {mount, {ruled.page_mm(), draw}, origin};
}

ReportList tool_page_list(const ToolPage& drawn) {
  const ToolMount& mount = drawn.mount;
  ReportList list;
  list.line("page", "{page_mm:g| x } mm", Vector2d(drawn.page.size_mm * kMillimetre));
  list.line("lamps", "{lamp_mm:g| and } mm wide, {separation_mm:g} mm apart",
            Vector2d(mount.lamps.diameters_m[0], mount.lamps.diameters_m[1]),
            mount.lamps.separation_m);
  list.line("reflector", "({reflector_mm:g}) mm from the end point, {ball_mm:g} mm wide",
            mount.p_TS, mount.ball_diameter);
  return list;
}

}  // namespace planar
