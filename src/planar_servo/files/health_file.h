#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/health/health_record.h"

namespace planar {

/// Returns the text of a health.yaml by `program`, made from `origins`.
std::string health_text(const HealthRecord& record, const std::string& program,
                        const std::vector<Origin>& origins);

/// Reads a health.yaml. Throws InputError naming every fault with its place.
HealthRecord read_health(const std::filesystem::path& path);

}  // namespace planar
