#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "peer.h"
#include "planar_servo/learn/error_map/error_sample.h"

namespace planar::bench {

/// Throws WorkError when the interpreter of bench/.venv cannot run scipy_peer.py.
void require_scipy();

/// Returns the scores of SciPy's RBFInterpolator by method, one per draw. It runs scipy_peer.py,
/// with which it exchanges files in `folder`. Throws WorkError when the script fails.
std::map<std::string, std::vector<Score>> run_scipy(
    const std::vector<std::vector<ErrorSample>>& draws, const std::vector<ErrorSample>& truth,
    const std::filesystem::path& folder);

}  // namespace planar::bench
