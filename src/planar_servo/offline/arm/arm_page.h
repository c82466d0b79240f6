#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/field/arm/arm_fit.h"
#include "planar_servo/report/html_page.h"

namespace planar {

/// Judges an arm by readings at places left out and by what the readings leave open.
Verdict arm_verdict(const ArmFit& fit);

/// Returns the page about an arm file.
std::string arm_page(const ArmFit& fit, const std::filesystem::path& file);

}  // namespace planar
