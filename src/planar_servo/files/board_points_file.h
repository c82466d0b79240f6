#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace planar {

/// Pixels of boards' points found by another program: one point a line, `u v` with a space or comma
/// between them, view after view; `#` comments and blank lines are skipped. Throws InputError
/// naming FILE:LINE of each other line.
std::vector<Eigen::Vector2d> read_board_pixels(const std::filesystem::path& path);

}  // namespace planar
