#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/workplane_calibration.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/health/health_record.h"

namespace planar {

/// Names the tables of a recording from which pairs are made.
struct RecordedTables {
  std::filesystem::path lamps, frames, tracker;
};

/// Names the files that hold pairs and what was fitted to make them.
struct PairFiles {
  std::filesystem::path workplane, tool, pairs;
};

/// Returns what lamps.csv is made from: the recording's frames, as far as there is one, and of the
/// cell its lamps, its image size and its camera; with the workplane, if that was used, and the
/// tool.
std::vector<Origin> origins_of_lamps(const CellSettings& cell, const std::filesystem::path& frames,
                                     bool with_workplane);

/// Returns a refusal for each table that was made with another camera, with other lamps or from
/// other frames. The workplane with which the lamps were located does not matter, because the
/// pairs make a new one.
std::vector<StaleFile> stale_tables(const CellSettings& cell, const RecordedTables& tables);

void write_pair_files(const PairFiles& files, const CellSettings& cell,
                      const RecordedTables& tables, const WorkplaneFit& fit, WorkplaneSource source,
                      const std::vector<PairRow>& pairs, const std::string& program);

/// Writes lays.csv, which is made with the camera from the recording's frames and the workplane of
/// `files`.
void write_lays_file(const std::filesystem::path& path, const CellSettings& cell,
                     const PairFiles& files, const RecordedTables& tables,
                     const std::vector<LayRow>& lays);

/// Writes health.yaml, which belongs to the camera and to the workplane and tool of `files`.
void write_health_file(const std::filesystem::path& path, const CellSettings& cell,
                       const PairFiles& files, const HealthRecord& record,
                       const std::string& program);

}  // namespace planar
