#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/run/dry_run.h"

namespace planar {

/// The first move to every target in turn.
std::vector<DryRunRow> plan_first_moves(const CellSettings& cell,
                                        const std::vector<TargetRow>& targets);

/// How many of them are refused.
std::size_t count_refused(const std::vector<DryRunRow>& rows);

/// A line for each target: the joints and pulses, or why it is refused.
std::string dry_run_text(const std::vector<DryRunRow>& rows);

/// A line for each target that is refused.
std::string refusals_text(const std::vector<DryRunRow>& rows);

/// One target's `target`, `status` ("planned" or "refused"), `reason`, and what the first move
/// commands: `theta_deg`, `pulses`.
nlohmann::ordered_json plan_answer(const DryRunRow& row);

/// Every target's answer under the key `moves`.
nlohmann::json dry_run_json(const std::vector<DryRunRow>& rows);

}  // namespace planar
