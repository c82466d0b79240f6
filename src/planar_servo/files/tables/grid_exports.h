#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/learn/error_map/error_grid.h"

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

std::string error_grid_text(const ErrorGrid& grid, const std::vector<std::string>& remarks);

/// The formats in which other programs read an error over the plane.
enum class GridFormat {
  kCsv,          ///< a table
  kNumpy,        ///< numpy.load(): a structured array, rows along y [NumPy Enhancement Proposal 1]
  kOpencvRemap,  ///< cv::FileStorage with the `map` of cv::remap()
};

constexpr Named<GridFormat> kGridFormats[] = {{GridFormat::kCsv, "grid-csv"},
                                              {GridFormat::kNumpy, "numpy"},
                                              {GridFormat::kOpencvRemap, "opencv-remap"}};

/// The kind of all these files; see require_writable().
constexpr char kErrorGridKind[] = "error_grid";

/// What a format is to its reader.
struct GridUse {
  bool over_true_places;  ///< nodes are where the end point truly is, not where it is seen
  const char* meaning;    ///< how its values are used
  const char* read_by;    ///< a call that reads it
};
GridUse use_of(GridFormat format);

/// Returns the file's text. `remarks` say what the grid is and was made from; each begins with '#'.
/// The nodes must be the places that use_of() names.
std::string grid_text(GridFormat format, const ErrorGrid& grid,
                      const std::vector<std::string>& remarks);

}  // namespace planar
