#include "planar_servo/offline/map/lamp_field_files.h"

#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/map/lamp_field_file.h"
#include "planar_servo/files/map/map_file.h"
#include "planar_servo/files/tables/lay_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/map/pose_samples.h"

namespace planar {

std::vector<MadeFile> LampFieldFiles::inputs() const {
  std::vector<MadeFile> files{{Role::kPairs, pairs}};
  if (!lays.empty()) files.push_back({Role::kLays, lays});
  return files;
}

LampFieldFit learn_lamp_field(const LampFieldFiles& files, const CellSettings& cell,
                              const VisionCalibration& vision, const Progress& progress) {
  warn_of_changed_rows(files.pairs);
  const LaidDots board = files.lays.empty() ? LaidDots() : laid_dots(read_lays(files.lays));
  return fit_lamp_field(nominal_arm(cell, vision), pose_samples(cell, read_pairs(files.pairs)),
                        board, progress);
}

void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::string& program) {
  std::vector<Origin> origins;
  for (const MadeFile& input : files.inputs()) origins.push_back(origin_of(input));
  origins = with_origins_of(std::move(origins), files.pairs);
  const std::string map = fit.end_point_map ? map_text(*fit.end_point_map, files.pairs, program)
                                            : lamp_field_text(fit, origins, program);
  if (!files.arm.empty()) {
    origins.push_back(arm_origin(cell));
    write_file(files.arm, found_arm_text(fit.arm, arm_terms(fit.estimate), origins, program));
  }
  write_file(files.map, map);
}

}  // namespace planar
