#include "planar_servo/offline/pairs/laid_boards.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/calibrate_camera.h"

namespace planar {
namespace {

/// Returns the same camera over the plane that lies `height` above this one.
Workplane raised(const Workplane& workplane, double height) {
  Pose X_WC = workplane.X_WC();
  X_WC.translation().z() -= height;
  return {workplane.camera(), X_WC};
}

/// Returns the median of the diameters that the dots' images show, in the board's unit.
double dot_diameter(const CameraModel& camera, const LaidBoard& laid,
                    const std::vector<Eigen::Vector2d>& points_G) {
  std::vector<double> diameters;
  for (std::size_t i = 0; i < points_G.size(); ++i)
    if (const auto diameter =
            disc_diameter(camera, laid.X_CG, points_G[i], laid.sight.dot_areas_px2[i]))
      diameters.push_back(*diameter);
  return median(diameters);
}

void add_lay(const Workplane& dots_plane, const LaidBoard& laid, std::vector<LayRow>& rows) {
  const CameraModel& camera = dots_plane.camera();
  const std::vector<Eigen::Vector2d> points_G = board_points(laid.board);
  const double diameter = dot_diameter(camera, laid, points_G);
  for (std::size_t i = 0; i < points_G.size(); ++i) {
    const auto shift_px = eccentricity_px(camera, laid.X_CG, points_G[i], diameter);
    if (!shift_px) continue;
    Eigen::Matrix2d m_per_px;
    const auto seen = dots_plane.plane_from_pixel(laid.sight.pixels[i] - *shift_px, &m_per_px);
    if (!seen) continue;
    const double sigma = laid.sight.dot_sigmas_px[i] * m_per_px.norm() / std::sqrt(2.0);
    const Eigen::Vector2d from_above(points_G[i].x(), -points_G[i].y());  // z_G points down
    rows.push_back({laid.lay, from_above, *seen, sigma, laid.board.pitch_known});
  }
}

// A calibrated lens errs by some ten-thousandths in scale, tenths of a millimetre in height.
constexpr double kHeightDoubt = 1.0 * kMillimetre;

using Lay = std::vector<const LayRow*>;

/// Returns the root of the sum of the squared distances from the middle.
double spread(const Lay& lay, Eigen::Vector2d LayRow::*place) {
  Eigen::Vector2d middle(0.0, 0.0);
  for (const LayRow* row : lay) middle += row->*place / static_cast<double>(lay.size());
  double squares = 0.0;
  for (const LayRow* row : lay) squares += (row->*place - middle).squaredNorm();
  return std::sqrt(squares);
}

/// Returns how far above the stated plane each lay must lie to be seen in its size.
std::map<std::string, double> apparent_heights(const std::vector<LayRow>& lays,
                                               double camera_height) {
  std::map<std::string, Lay> rows_of;
  for (const LayRow& row : lays)
    if (row.pitch_known) rows_of[row.lay].push_back(&row);
  std::map<std::string, double> heights;
  for (const auto& [lay, rows] : rows_of) {
    const double true_over_seen = spread(rows, &LayRow::p_board) / spread(rows, &LayRow::p_seen);
    heights[lay] = camera_height * (1.0 - true_over_seen);
  }
  return heights;
}

std::string above_or_below(double height) {
  return fmt::format("{:.1f} mm {}", mm(std::abs(height)), height > 0.0 ? "above" : "below");
}

}  // namespace

std::vector<LaidBoard> boards_on_plane(const std::filesystem::path& recording,
                                       const std::vector<FrameRow>& frames,
                                       const CameraModel& camera, const Board& board) {
  Faults faults;
  std::vector<LaidBoard> boards;
  std::vector<std::filesystem::path> files;
  for (const FrameRow& frame : frames)
    if (frame.plan == Purpose::kLaidBoard) files.push_back(recording / frame.image);
  const PictureSet set(files);
  for (const FrameRow& frame : frames) {
    if (frame.plan != Purpose::kLaidBoard) continue;
    const std::filesystem::path file = recording / frame.image;
    const cv::Mat image = read_grey(set, file, faults);
    if (image.empty()) continue;
    const BoardSight sight = find_board_on_sensor(image, frame.region_px.tl(), board);
    const auto pose = sight.found() ? estimate_board_pose(camera, board_points(board), sight.pixels)
                                    : std::nullopt;
    if (pose) {
      boards.push_back({file.stem().string(), pose->X_CG, board, sight});
    } else {
      faults.add({"no board on the plane: " + (sight.found() ? "no pose" : sight.reason), "", file,
                  Cause::kInsufficient});
    }
  }
  faults.throw_if_any();
  if (boards.empty())
    throw InputError({"has no frame of plan 'plane_grid'",
                      "record one with the board on the plane, or take --workplane-from pairs "
                      "without --lays-out",
                      recording, Cause::kMissing});
  return boards;
}

std::vector<LayRow> seen_lays(const Workplane& workplane, const std::vector<LaidBoard>& boards,
                              double dots_height) {
  const Workplane dots_plane = raised(workplane, dots_height);
  std::vector<LayRow> rows;
  for (const LaidBoard& laid : boards) {
    if (!laid.board.has_dots())
      throw InputError(Refusal{"lays of a chessboard have no dots", "lay a board of circles"});
    add_lay(dots_plane, laid, rows);
  }
  return rows;
}

std::vector<Refusal> doubts_of_lays(const std::vector<LayRow>& lays, double camera_height) {
  const std::map<std::string, double> heights = apparent_heights(lays, camera_height);
  if (heights.empty()) return {};
  const double middle = median(each(heights, [](const auto& lay) { return lay.second; }));
  std::vector<Refusal> doubts;
  if (std::abs(middle) > kHeightDoubt)
    doubts.push_back(
        {fmt::format("the boards are seen as if their dots lay {} the plane that was stated",
                     above_or_below(middle)),
         "check --board-thickness-mm and the pitch in --grid", "lays", Cause::kContradiction});
  for (const auto& [lay, height] : heights)
    if (std::abs(height - middle) > kHeightDoubt)
      doubts.push_back({fmt::format("'{}' is seen as if it lay {} the others", lay,
                                    above_or_below(height - middle)),
                        "lay it flat and record it again, or leave it out", "lays",
                        Cause::kContradiction});
  return doubts;
}

}  // namespace planar
