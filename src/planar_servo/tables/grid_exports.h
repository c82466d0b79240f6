#pragma once

#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/error_map/error_grid.h"

namespace planar {

/// The formats in which other programs read an error over the plane.
enum class GridFormat {
  kCsv,          ///< a table; see tables/error_grid_table.h
  kNumpy,        ///< numpy.load(): a structured array, rows along y [NumPy Enhancement Proposal 1]
  kOpencvRemap,  ///< cv::FileStorage with the `map` of cv::remap()
  kTinshift,     ///< PROJ's +proj=tinshift: triangles in JSON [PROJ RFC 6]
};

constexpr Named<GridFormat> kGridFormats[] = {{GridFormat::kCsv, "grid-csv"},
                                              {GridFormat::kNumpy, "numpy"},
                                              {GridFormat::kOpencvRemap, "opencv-remap"},
                                              {GridFormat::kTinshift, "tinshift"}};

/// The kind of all these files; see require_writable().
constexpr char kErrorGridKind[] = "error_grid";

/// What a format is to its reader.
struct GridUse {
  bool over_true_places;  ///< nodes are where the end point truly is, not where it is seen
  GridReading reading;    ///< of its reader
  const char* meaning;    ///< how its values are used
  const char* read_by;    ///< a call that reads it
};
GridUse use_of(GridFormat format);

/// Returns the file's text. `remarks` say what the grid is and was made from; each begins with '#'.
/// The nodes must be the places that use_of() names.
std::string grid_text(GridFormat format, const ErrorGrid& grid,
                      const std::vector<std::string>& remarks);

}  // namespace planar
