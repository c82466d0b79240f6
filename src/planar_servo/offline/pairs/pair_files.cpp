#include "planar_servo/offline/pairs/pair_files.h"

#include "planar_servo/files/tool_file.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

std::vector<Origin> origins_of_fit(const CellSettings& cell, const RecordedTables& tables) {
  std::vector<Origin> origins = origins_in(cell);
  origins.push_back(origin_of({Role::kCamera, cell.camera_model}));
  origins.push_back(origin_of({Role::kLamps, tables.lamps}));
  origins.push_back(origin_of({Role::kFrames, tables.frames}));
  origins.push_back(origin_of({Role::kTracker, tables.tracker}));
  return origins;
}

}  // namespace

std::vector<Origin> origins_of_lamps(const CellSettings& cell, const std::filesystem::path& frames,
                                     bool with_workplane) {
  std::vector<MadeFile> files{{Role::kFrames, frames}, {Role::kCamera, cell.camera_model}};
  if (with_workplane) {
    files.push_back({Role::kWorkplane, cell.workplane});
    files.push_back({Role::kTool, cell.tool});
  }
  std::vector<Origin> origins = origins_in(cell);
  for (const MadeFile& file : files)
    if (std::filesystem::exists(file.path)) origins.push_back(origin_of(file));
  return origins;
}

std::vector<StaleFile> stale_tables(const CellSettings& cell, const RecordedTables& tables) {
  std::vector<Origin> present = origins_in(cell);
  present.push_back(origin_of({Role::kCamera, cell.camera_model}));
  present.push_back(origin_of({Role::kFrames, tables.frames}));
  return contradictions({{Role::kLamps, tables.lamps}}, present,
                        {Role::kCamera, Role::kFrames, Role::kLampLayout, Role::kImageSize});
}

void write_pair_files(const PairFiles& files, const CellSettings& cell,
                      const RecordedTables& tables, const WorkplaneFit& fit, WorkplaneSource source,
                      const std::vector<PairRow>& pairs, const std::string& program) {
  std::vector<Origin> origins = origins_of_fit(cell, tables);
  const std::string workplane = workplane_text(
      {fit.X_WC, fit.covariance, source, fit.absorbed, static_cast<int>(fit.n_used), fit.rms},
      program, origins);
  const std::string tool = tool_text(fit.tool, program, origins);
  origins.push_back(origin_of({Role::kWorkplane, files.workplane}, workplane));
  origins.push_back(origin_of({Role::kTool, files.tool}, tool));
  write_file(files.workplane, workplane);
  write_file(files.tool, tool);
  write_file(files.pairs, pairs_text(pairs, csv_remarks(origins)));
}

}  // namespace planar
