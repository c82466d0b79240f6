#pragma once

#include <vector>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// Returns how the loop is closed with a chain. It goes on with the run that the experiment's
/// folder holds.
ServoRequest control_loop(const CalibratedChain& chain, bool with_map,
                          const ExperimentRequest& experiment);

/// Returns whether an experiment has begun to close the loop with our chain. Its recording is
/// complete then, and must not grow any more: the chains were calibrated from it.
bool has_begun_loop(const ExperimentRequest& experiment);

/// Returns whether the run of a loop has a result of every target.
bool is_done(const ServoRequest& loop, const std::vector<TargetRow>& targets);

/// Returns the loop's chain and folder, as in "ours run".
std::string name_of(const ServoRequest& loop);

/// Moves to the targets that have no result yet and returns the results of all.
std::vector<TargetResult> close_loop(const ServoRequest& loop,
                                     const std::vector<TargetRow>& targets, CellDevices& devices);

}  // namespace planar
