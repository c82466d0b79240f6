#include "planar_servo/offline/pairs/lay_check.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

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
  return fmt::format("{:.1f} mm {}", std::abs(height) / kMillimetre,
                     height > 0.0 ? "above" : "below");
}

}  // namespace

std::vector<std::string> doubts_of_lays(const std::vector<LayRow>& lays, double camera_height) {
  const std::map<std::string, double> heights = apparent_heights(lays, camera_height);
  if (heights.empty()) return {};
  std::vector<double> all;
  all.reserve(heights.size());
  for (const auto& [lay, height] : heights) all.push_back(height);
  const double middle = median(all);
  std::vector<std::string> doubts;
  if (std::abs(middle) > kHeightDoubt)
    doubts.push_back(
        fmt::format("lays: the boards are seen as if their dots lay {} the plane that was stated; "
                    "check --board-thickness-mm and the pitch in --grid",
                    above_or_below(middle)));
  for (const auto& [lay, height] : heights)
    if (std::abs(height - middle) > kHeightDoubt)
      doubts.push_back(
          fmt::format("lays: '{}' is seen as if it lay {} the others; lay it flat and "
                      "record it again, or leave it out",
                      lay, above_or_below(height - middle)));
  return doubts;
}

}  // namespace planar
