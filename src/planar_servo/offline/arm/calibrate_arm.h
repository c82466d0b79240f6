#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/field/arm/arm_fit.h"

namespace planar {

/// Reads the tracker's readings of the reflector with the commanded joints, from pairs.csv or from
/// samples.csv. Throws InputError as their readers do, and naming a pair that lacks its joints, its
/// reflector or a standard deviation.
std::vector<ArmReading> read_arm_readings(const CellSettings& cell,
                                          const std::filesystem::path& path);

/// Returns the arm as the cell has it, and its tool as far as there is a tool file. Without one the
/// reflector may be anywhere on the tool.
ArmNominal arm_of_files(const CellSettings& cell);

/// Returns what was found, as a table for a terminal.
std::string arm_report_text(const ArmFit& fit);

/// Returns the figures under the keys of --json.
nlohmann::json arm_report_json(const ArmFit& fit);

/// Returns what a pose says of the arm: every number with its standard deviation.
std::string arm_terms_text(const JointEstimate& estimate);

/// Returns the same with a key for each number: value, sigma, determined.
nlohmann::json arm_terms_json(const JointEstimate& estimate);

}  // namespace planar
