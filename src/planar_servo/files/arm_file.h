#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/learn/field/arm/arm_fit.h"

namespace planar {

/// Returns the text of arm.yaml: an `arm` block with links, zeros and harmonics as they were found,
/// and every term with its standard deviation and whether the poses determine it.
std::string found_arm_text(const FoundArm& arm, const std::vector<ArmTerm>& terms,
                           const std::vector<Origin>& origins, const std::string& program);

/// Reads the arm from arm.yaml. Throws InputError naming every fault.
FoundArm read_found_arm(const std::filesystem::path& path);

/// Returns what the learned arm of a cell is made from: arm.yaml and map.yaml.
std::vector<Origin> learned_arm_origins(const CellSettings& cell);

/// Returns the text of arm_learned.yaml: an `arm` block as arm.yaml has it, and its covariance.
std::string learned_arm_text(const LearnedArm& learned, const std::vector<Origin>& origins,
                             const std::string& program);

/// Reads arm_learned.yaml. The form has neither sense, coupling nor gears. Throws InputError naming
/// every fault.
LearnedArm read_learned_arm(const std::filesystem::path& path);

/// Says which of these origins the file was not learned with; empty when it belongs to them.
std::optional<std::string> learned_elsewhere(const std::filesystem::path& path,
                                             const std::vector<Origin>& origins);

}  // namespace planar
