#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/run/dry_run.h"

namespace planar {

/// Plans the first move to every target in turn.
std::vector<DryRunRow> plan_first_moves(const CellSettings& cell,
                                        const std::vector<TargetRow>& targets);

/// Counts the targets that are refused.
std::size_t count_refused(const std::vector<DryRunRow>& rows);

/// Returns a line for each target: its joints and pulses, or why it is refused.
std::string dry_run_text(const std::vector<DryRunRow>& rows);

/// Returns a line for each target that is refused.
std::string refusals_text(const std::vector<DryRunRow>& rows);

/// Returns one target's `target`, `status` ("planned" or "refused"), `reason`, and what the first
/// move commands: `theta_deg` and `pulses`.
nlohmann::ordered_json plan_answer(const DryRunRow& row);

/// Returns every target's answer under the key `moves`.
nlohmann::json dry_run_json(const std::vector<DryRunRow>& rows);

}  // namespace planar
