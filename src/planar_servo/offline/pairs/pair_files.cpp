#include "planar_servo/offline/pairs/pair_files.h"

#include "planar_servo/base/io/atomic_file.h"

namespace planar {

std::vector<Origin> origins_of_lamps(const CellSettings& cell, const std::filesystem::path& frames,
                                     bool with_workplane) {
  std::vector<MadeFile> files{{Role::kFrames, frames}, {Role::kCamera, cell.camera_model}};
  if (with_workplane) {
    files.push_back({Role::kWorkplane, cell.workplane});
    files.push_back({Role::kTool, cell.tool});
  }
  return origins_in(cell, files);
}

std::vector<StaleFile> stale_tables(const CellSettings& cell, const RecordedTables& tables) {
  return contradictions({{Role::kLamps, tables.lamps}},
                        origins_of_lamps(cell, tables.frames, false),
                        {Role::kCamera, Role::kFrames, Role::kLampLayout, Role::kImageSize});
}

void write_pair_files(const PairFiles& files, const CellSettings& cell,
                      const RecordedTables& tables, const WorkplaneFit& fit, WorkplaneSource source,
                      const std::vector<PairRow>& pairs, const std::string& program) {
  std::vector<Origin> origins = origins_in(cell, {{Role::kCamera, cell.camera_model},
                                                  {Role::kLamps, tables.lamps},
                                                  {Role::kFrames, tables.frames},
                                                  {Role::kTracker, tables.tracker}});
  const std::string workplane =
      workplane_text({fit.X_WC, fit.covariance, source, fit.absorbed, static_cast<int>(fit.n_used),
                      fit.rms, read_reference_remarks(tables.lamps)},
                     program, origins);
  const std::string tool = tool_text(fit.tool, program, origins);
  origins.push_back(origin_of({Role::kWorkplane, files.workplane}, workplane));
  origins.push_back(origin_of({Role::kTool, files.tool}, tool));
  write_file(files.workplane, workplane);
  write_file(files.tool, tool);
  write_file(files.pairs, with_row_hash(pairs_text(pairs, csv_remarks(origins))));
}

void write_lays_file(const std::filesystem::path& path, const CellSettings& cell,
                     const PairFiles& files, const RecordedTables& tables,
                     const std::vector<LayRow>& lays) {
  const std::vector<Origin> origins = origins_in(cell, {{Role::kCamera, cell.camera_model},
                                                        {Role::kFrames, tables.frames},
                                                        {Role::kWorkplane, files.workplane}});
  write_file(path, with_row_hash(lays_text(lays, csv_remarks(origins))));
}

void write_health_file(const std::filesystem::path& path, const CellSettings& cell,
                       const PairFiles& files, const HealthRecord& record,
                       const std::string& program) {
  std::vector<Origin> origins = origins_in(cell, {{Role::kCamera, cell.camera_model},
                                                  {Role::kWorkplane, files.workplane},
                                                  {Role::kTool, files.tool}});
  origins.push_back(arm_origin(cell));
  write_file(path, health_text(record, program, origins));
}

}  // namespace planar
