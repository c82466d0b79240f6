#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/error_map/error_map.h"
#include "planar_servo/files/tables/pair_table.h"

namespace planar {

/// How well a map predicts pairs that it was not fitted to; lengths in metres.
struct MapCheck {
  std::size_t n_outside{0};  ///< pairs outside the map's valid region; they count like the others
  Summary raw;               ///< of |E|
  Summary compensated;       ///< of |E - map|
  double a1{0.0};            ///< 1 - mean |E - map| / mean |E|
  double a2{0.0};  ///< 1 - |mean |E| - mean |map|| / mean |E|: the paper's, blind to direction
  /// Share of the components of E - map within 1.96 standard deviations: the map's and, added to
  /// it, the pair's own noise as its row states it, else as the map found it. NaN for a map without
  /// standard deviations.
  double coverage_95{0.0};
};

/// The pairs of the named plans; without names, those whose plan is not `train` (every pair when
/// they name no plans). Throws InputError when there are none.
std::vector<PairRow> pairs_to_check(std::vector<PairRow> pairs,
                                    const std::vector<std::string>& plans);

/// Throws InputError naming the file of the pairs when the map depends on the tool's direction and
/// a pair names none.
void require_directions(const ErrorMap& map, const std::vector<PairRow>& pairs,
                        const std::filesystem::path& file);

/// At least one pair, each as `require_directions` has it. Throws InputError for three or more that
/// are not in one unit and frame.
MapCheck check_error_map(const ErrorMap& map, const std::vector<PairRow>& pairs,
                         const Progress& progress = {});

}  // namespace planar
