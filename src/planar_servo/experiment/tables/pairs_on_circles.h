#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/files/tables/pair_table.h"

namespace planar {

/// Finds the pairs of a recording that lie on the circles of its plan.
class PairsOnCircles {
 public:
  /// Refers to both lists, which must outlive it.
  PairsOnCircles(const std::vector<PairRow>& pairs, const std::vector<CirclePoint>& points);

  /// Returns the pairs of a circle that checks the maps, in its order. Throws WorkError when there
  /// are none.
  std::vector<PairRow> check_circle(int radius_mm) const;

  /// Returns the places of one circle that every run has, in its order. Throws WorkError when there
  /// are none.
  std::vector<std::array<const PairRow*, kRuns>> of_all_runs(int radius_mm) const;

  /// Returns the pair of a place, or nullptr when it was left out.
  const PairRow* pair_at(const CirclePoint& point) const;

 private:
  const std::vector<CirclePoint>& points_;
  std::map<std::string, const PairRow*> by_id_;
};

}  // namespace planar
