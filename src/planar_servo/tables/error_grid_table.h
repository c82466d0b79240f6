#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/error_map/error_grid.h"
#include "planar_servo/io/columns.h"

namespace planar {

// A table of errors over the plane, with columns x_mm, y_mm, dx_mm, dy_mm and optional sigma_mm and
// valid: compensated = (x, y) - (dx, dy). Any program may have made it.

/// Holds a row: the error where vision, or another system, sees a place. Metres.
struct ErrorGridRow {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
  std::optional<double> sigma{};  ///< of the error per axis
  std::optional<bool> valid{};
};

const TableSchema<ErrorGridRow>& error_grid_schema();

/// Returns whether a file's columns are those of such a table. False for what cannot be read.
bool is_error_grid(const std::filesystem::path& path);

std::string error_grid_text(const ErrorGrid& grid, const std::vector<std::string>& remarks);

}  // namespace planar
