#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "planar_servo/files/tables/pair_table.h"

namespace planar {

/// How a map is to be fitted, as the option --method has it: auto, rbf, idw or hand:WIDTH_MM.
struct MapMethodChoice {
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth
};

/// Throws InputError naming the methods there are.
MapMethodChoice parse_map_method(const std::string& text);

/// What a map is to be fitted to: the pairs of plan `train`, and those without a plan.
struct TrainingPairs {
  MapProblem problem;
  std::size_t n_other_plans{0};  ///< pairs left alone
};

/// From pairs.csv. Throws InputError as `read_pairs` does, and when no pair is to be fitted to.
TrainingPairs read_training_pairs(const std::filesystem::path& path, const MapMethodChoice& choice);

struct FitErrorMapReport {
  MapResult result;
  std::size_t n_other_plans{0};
  double fit_seconds{0.0};
};

FitErrorMapReport fit_error_map_to_pairs(const TrainingPairs& pairs, const Progress& progress = {});
FitErrorMapReport fit_error_map_to_pairs(const std::vector<PairRow>& pairs,
                                         const MapMethodChoice& choice);

}  // namespace planar
