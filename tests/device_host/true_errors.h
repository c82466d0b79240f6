#pragma once

#include <filesystem>
#include <vector>

#include "device_host/hosted_arm.h"
#include "planar_servo/base/core/statistics.h"

namespace planar::test {

/// How far from each target of a run the tool really was when the run looked at it last, metres.
/// Throws InputError for files that are not a run's, and for a target that was never looked at.
std::vector<double> true_errors(const std::filesystem::path& targets,
                                const std::filesystem::path& run, const std::vector<TrueTip>& tips);

}  // namespace planar::test
