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

/// A trend of the vision error over the training pairs.
struct RecordedTrend {
  ErrorTrend trend;
  double duration_s{0.0};  ///< from the first place to the last; 0 where the times are not known

  /// Returns whether the pairs are to be used only when a person says so.
  bool is_dear() const;
};

/// Looks for a step as find_change() does.
std::optional<RecordedStep> find_step(const std::vector<PairRow>& pairs);

/// Looks for a trend as find_trend() does. One that moves less over the whole recording than a
/// revisit of the calibration names as a change is none.
std::optional<RecordedTrend> find_trend(const std::vector<PairRow>& pairs);

/// How the vision errors of the training pairs scatter about any smooth error, per axis, metres.
struct RecordedScatter {
  double found{0.0};
  double stated{0.0};  ///< of tracker and lamps together
};

/// Returns it where it is clearly more than is stated.
std::optional<RecordedScatter> find_scatter(const std::vector<PairRow>& pairs);

std::string scatter_doubt(const RecordedScatter& scatter);

/// Returns what is doubted of a trend: size, rate, deviation, causes, and what to do.
std::string trend_doubt(const RecordedTrend& trend);

/// Returns what is doubted: place, size, deviation, cost, causes, and what to do.
std::string step_doubt(const RecordedStep& step);

}  // namespace planar
