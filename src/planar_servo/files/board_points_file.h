#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace planar {

/// Reads the pixels of boards' points that another program found. Each line holds one point, `u v`
/// with a space or comma between them, view after view. `#` comments and blank lines are skipped.
/// Throws InputError naming FILE:LINE of each other line, and for a file without points.
std::vector<Eigen::Vector2d> read_board_pixels(const std::filesystem::path& path);

}  // namespace planar
