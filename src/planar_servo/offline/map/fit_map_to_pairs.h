#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "planar_servo/tables/pair_table.h"

namespace planar {

/// Says how a map is to be fitted. The option --method names it: auto, rbf, idw or hand:WIDTH_MM.
struct MapMethodChoice {
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth
};

/// Reads the value of --method. Throws InputError naming the methods there are.
MapMethodChoice parse_map_method(const std::string& text);

/// Holds the pairs to which a map is to be fitted: those of plan `train` and those without a plan.
struct TrainingPairs {
  MapProblem problem;
  std::size_t n_other_plans{0};  ///< number of pairs of other plans
  std::size_t n_unattended{0};   ///< number of poses without a tracker reading
};

/// Says in the log that rows were changed after they had been written, which may have been meant.
void warn_of_changed_rows(const std::filesystem::path& pairs);

/// Reads training pairs from pairs.csv. Throws InputError as read_pairs() does, and when there is
/// no pair to be fitted to.
TrainingPairs read_training_pairs(const std::filesystem::path& path, const MapMethodChoice& choice);

/// Holds a fitted map and what the fit took.
struct FitErrorMapReport {
  MapResult result;
  std::size_t n_other_plans{0};
  std::size_t n_unattended{0};
  double fit_seconds{0.0};
};

/// Fits a map to training pairs; see fit_error_map().
FitErrorMapReport fit_error_map_to_pairs(const TrainingPairs& pairs, const Progress& progress = {});
/// Fits a map to those of the pairs that are for training.
FitErrorMapReport fit_error_map_to_pairs(const std::vector<PairRow>& pairs,
                                         const MapMethodChoice& choice);

}  // namespace planar
