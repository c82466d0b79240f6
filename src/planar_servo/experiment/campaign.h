#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "planar_servo/experiment/campaign_rows.h"
#include "planar_servo/experiment/experiment.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// The seeds of a campaign: `first`, `first` + 1, ...
struct SeedRange {
  std::uint32_t first{1};
  int count{1};
};

/// Has every seed's row added, in whatever order programs that share the campaign come to the
/// seeds, and returns the rows in the order of the seeds. `experiment` finds the figures of a seed
/// that has no row yet and that no other program is at. What another program has begun is waited
/// for, and done here if that program ends without its row. Throws what `experiment` throws.
std::vector<nlohmann::json> work_through(
    CampaignRows& rows, const SeedRange& seeds,
    const std::function<nlohmann::json(std::uint32_t seed)>& experiment);

/// Runs the experiment on virtual cells that differ from the request's in their truth alone, which
/// `draw` of kCellKinds draws from the seeds; request.seed is not used. Rows go to `rows.jsonl` in
/// request.out. The folder `seed_N` of a cell, with a recording of about a gigabyte, lasts until
/// its row is there; what a killed program left of it is begun anew, so that the rows do not tell
/// who found them and when. Throws what run_experiment() throws, and InputError when the folder
/// holds something else, or rows of another kind, when either the cell file or the kind alone has
/// reference lamps, and when the cell's links or sensor are not about those of the kind.
std::vector<nlohmann::json> run_campaign(const ExperimentRequest& request, const SeedRange& seeds,
                                         DrawTruth draw);

}  // namespace planar
