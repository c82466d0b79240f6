#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/learn/field/arm/arm_fit.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Reads the tracker's readings of the reflector with the commanded joints, from pairs.csv or from
/// samples.csv. Throws InputError as their readers do, and naming a pair that lacks its joints, its
/// reflector or a standard deviation.
std::vector<ArmReading> read_arm_readings(const CellSettings& cell,
                                          const std::filesystem::path& path);

/// Returns the arm and the lamps' distance as the cell file has them.
ArmNominal arm_of_cell(const CellSettings& cell);

/// Returns the arm as the cell has it, and its tool as far as there is a tool file. Without one the
/// reflector may be anywhere on the tool.
ArmNominal arm_of_files(const CellSettings& cell);

ReportList arm_list(const ArmFit& fit);

/// Lists every number of the arm with its standard deviation, and whether it is determined.
ReportList arm_terms_list(const JointEstimate& estimate);

/// Says whether an arm is good, by readings at places left out and by what the readings leave open.
Verdict arm_verdict(const ArmFit& fit);

std::string arm_page(const ArmFit& fit, const std::filesystem::path& file);

}  // namespace planar
