#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/readings/change_point.h"
#include "planar_servo/files/tables/pair_table.h"

namespace planar {

/// A step in the vision error of the training pairs, in the order of time.
struct RecordedStep {
  std::string id;         ///< of the first place after it
  std::size_t places{0};  ///< training places in all
  ChangePoint change;

  /// Returns by how much a map of these pairs misses the end point, in the mean over the field and
  /// for the worse of the two states, metres.
  double cost() const { return change.cost(places); }
  /// Returns whether the pairs are to be used only when a person says so.
  bool is_dear() const;
};

/// Looks for a step as find_change() does.
std::optional<RecordedStep> find_step(const std::vector<PairRow>& pairs);

/// Returns what is doubted: place, size, deviation, cost, causes, and what to do.
std::string step_doubt(const RecordedStep& step);

}  // namespace planar
