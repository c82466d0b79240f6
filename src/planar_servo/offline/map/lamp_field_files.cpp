#include "planar_servo/offline/map/lamp_field_files.h"

#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/map/lamp_field_file.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {

void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::filesystem::path& pairs,
                      const std::string& program) {
  std::vector<Origin> origins = with_origins_of({origin_of({Role::kPairs, pairs})}, pairs);
  const std::string map = lamp_field_text(fit, origins, program);
  if (!files.arm.empty()) {
    origins.push_back(arm_origin(cell));
    write_file(files.arm,
               found_arm_text(found_arm(fit.estimate), arm_terms(fit.estimate), origins, program));
  }
  write_file(files.map, map);
}

}  // namespace planar
