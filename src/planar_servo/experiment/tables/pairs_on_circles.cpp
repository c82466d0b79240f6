#include "planar_servo/experiment/tables/pairs_on_circles.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

[[noreturn]] void refuse_empty_circle(int radius_mm) {
  throw WorkError(
      fmt::format("no place on the circle of radius {} mm has both lamps and a tracker "
                  "reading; lamps.csv says why",
                  radius_mm));
}

}  // namespace

PairsOnCircles::PairsOnCircles(const std::vector<PairRow>& pairs,
                               const std::vector<CirclePoint>& points)
    : points_(points) {
  for (const PairRow& pair : pairs) by_id_.emplace(pair.id, &pair);
}

std::vector<PairRow> PairsOnCircles::check_circle(int radius_mm) const {
  std::vector<PairRow> pairs;
  for (const CirclePoint& point : points_)
    if (point.run == 0 && point.radius_mm == radius_mm)
      if (const PairRow* pair = pair_at(point)) pairs.push_back(*pair);
  if (pairs.empty()) refuse_empty_circle(radius_mm);
  return pairs;
}

std::vector<std::array<const PairRow*, kRuns>> PairsOnCircles::of_all_runs(int radius_mm) const {
  std::map<int, std::array<const PairRow*, kRuns>> by_index;
  for (const CirclePoint& point : points_)
    if (point.run > 0 && point.radius_mm == radius_mm)
      by_index[point.index].at(static_cast<std::size_t>(point.run - 1)) = pair_at(point);
  std::vector<std::array<const PairRow*, kRuns>> complete;
  for (const auto& [index, pairs] : by_index)
    if (std::count(pairs.begin(), pairs.end(), nullptr) == 0) complete.push_back(pairs);
  if (complete.empty()) refuse_empty_circle(radius_mm);
  return complete;
}

const PairRow* PairsOnCircles::pair_at(const CirclePoint& point) const {
  const auto found = by_id_.find(point.id);
  return found == by_id_.end() ? nullptr : found->second;
}

}  // namespace planar
