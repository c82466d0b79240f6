#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error_map/compare_methods.h"
#include "error_map/fit_error_map.h"
#include "files/tables.h"

namespace planar {

/// How a map is to be fitted, as the option --method has it: auto, rbf, idw or hand:WIDTH_MM.
struct MapMethodChoice {
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth
};

/// Throws InputError naming the methods there are.
MapMethodChoice parse_map_method(const std::string& text);

struct FitErrorMapReport {
  MapResult result;
  std::size_t n_other_plans{0};  ///< pairs left alone because their plan is not `train`
  double fit_seconds{0.0};
};

/// Fits a map to the pairs; when they name plans, only to those of plan `train`.
FitErrorMapReport fit_error_map_to_pairs(const std::vector<PairRow>& pairs,
                                         const MapMethodChoice& choice);

/// `compare_methods` for the same pairs and choice as `result` was fitted with.
std::vector<MethodFigures> compare_methods_on_pairs(const std::vector<PairRow>& pairs,
                                                    const MapMethodChoice& choice,
                                                    const MapResult& result);

}  // namespace planar
