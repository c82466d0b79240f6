#pragma once

#include <vector>

#include "planar_servo/base/core/purpose.h"
#include "planar_servo/files/tables/recording_tables.h"

namespace planar::test {

/// Returns the mean distance from each training place to the next, divided by that of any two of
/// them: 1 for an order that is random in space.
inline double step_over_distance(const std::vector<PlanRow>& rows) {
  std::vector<Eigen::Vector2d> places;
  for (const PlanRow& row : rows)
    if (row.plan == Purpose::kTrain) places.push_back(std::get<TipPose>(row.where).p);
  const auto n = static_cast<double>(places.size());
  double steps = 0.0, distances = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i > 0) steps += (places[i] - places[i - 1]).norm() / (n - 1.0);
    for (std::size_t j = 0; j < i; ++j)
      distances += (places[i] - places[j]).norm() / (0.5 * n * (n - 1.0));
  }
  return steps / distances;
}

}  // namespace planar::test
