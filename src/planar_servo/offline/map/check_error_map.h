#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/tables/pair_table.h"
#include "planar_servo/vision/see_tool.h"

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
std::vector<PairRow> pairs_to_check(std::vector<PairRow> pairs, const std::vector<Plan>& plans);

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

}  // namespace planar
