#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/io/csv/csv_table.h"

namespace planar {

/// Holds one row of a recording's tracker.csv: the reflector's centre in the tracker's frame,
/// metres.
struct TrackerRow {
  std::string id;
  double t_s{0.0};
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};
};

/// Reads RECORDING/tracker.csv, or another program's table of readings. Throws InputError naming
/// FILE:LINE of each bad row, and for a table without rows.
std::vector<TrackerRow> read_tracker(const std::filesystem::path& path,
                                     const CsvDialect& dialect = {});

// The table grows: the header first, then a line at a time.
std::string tracker_header();
std::string tracker_line(const TrackerRow& row);

}  // namespace planar
