#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Says how well a map predicts pairs that it was not fitted to. Lengths are in metres.
struct MapCheck {
  std::size_t n_outside{0};  ///< pairs outside the map's valid region, which count like the others
  Summary raw;               ///< figures of |E|
  Summary compensated;       ///< figures of |E - map|
  double a1{0.0};            ///< 1 - mean |E - map| / mean |E|
  /// 1 - |mean |E| - mean |map|| / mean |E|. This is the paper's accuracy, which is blind to
  /// direction.
  double a2{0.0};
  /// The share of the components of E - map that lie within 1.96 standard deviations. The variance
  /// is the map's plus the pair's own noise, as its row states it or else as the map found it. NaN
  /// for a map without standard deviations.
  double coverage_95{0.0};
};

/// Returns the attended pairs of the named plans. Without names it returns those whose plan is not
/// `train`, which are all when the pairs name no plans. Throws InputError when there are none.
std::vector<PairRow> pairs_to_check(std::vector<PairRow> pairs, const std::vector<Purpose>& plans);

/// Throws InputError naming the pairs' file when a pair lacks what the map depends on: the tool's
/// direction, or the lamps and the reflector.
void require_what_it_needs(const VisionErrorMap& map, const std::vector<PairRow>& pairs,
                           const std::filesystem::path& file);

/// Compares a map with at least one pair, each attended and as require_what_it_needs() demands. A
/// field at the lamps is compared with the tracker's reading of the reflector, by the tool that it
/// was found with. Throws InputError for three or more pairs that are not in one unit and frame.
MapCheck check_error_map(const VisionErrorMap& map, const std::vector<PairRow>& pairs,
                         const Progress& progress = {});

/// Lists how a map does on other pairs. `n_left_out` is the number of pairs of other plans.
ReportList map_check_list(const MapCheck& check, std::size_t n_left_out);

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
