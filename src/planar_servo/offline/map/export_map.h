#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "planar_servo/files/tables/grid_exports.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/learn/error_map/error_grid.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Which map is to be exported, and how.
struct ExportRequest {
  std::filesystem::path map;
  std::optional<CellSettings> cell;  ///< needed for a field at the lamps: it says where they are
  GridFormat format{GridFormat::kCsv};
  std::optional<double> phi;   ///< of the tool, radians
  std::optional<double> step;  ///< of the grid, metres; by default the largest that is fine enough
  bool accept_map{false};      ///< exports even a map that its own fit rejects
};

/// A map as another program reads it.
struct ExportedMap {
  GridFormat format{GridFormat::kCsv};
  std::string method;
  SampledError sampled;
  double phi{0.0};              ///< of the tool for which it holds, radians
  double change_with_phi{0.0};  ///< largest change of the error with phi, metres
  std::string text;             ///< of the file
};

/// Samples a map and returns it as text in a format. Throws InputError for a map that its own fit
/// rejects, for one whose error changes with the tool's direction by more than its deviation when
/// the request names no direction, and as sample_error() does.
ExportedMap export_map(const ExportRequest& request);

/// Lists what was exported and what it costs to read the grid.
ReportList exported_map_list(const ExportedMap& exported);

}  // namespace planar
