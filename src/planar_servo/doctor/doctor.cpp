#include "planar_servo/doctor/doctor.h"

#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

std::vector<Finding> examine_cell(const std::filesystem::path& cell_file) {
  const CellSettings cell = read_cell(cell_file);
  require_devices(cell);
  std::vector<Finding> findings{
      {Finding::Verdict::kWell, "cell file", cell_file.string() + " is in order"}};
  for (Finding& finding : cell.drives[0].kind->examine(cell))
    findings.push_back(std::move(finding));
  for (Finding& finding : cell.camera.kind->examine(cell)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace planar
