#include "planar_servo/doctor/doctor.h"

#include <fmt/format.h>

#include <utility>

#include "planar_servo/files/provenance.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

namespace {

using Verdict = Finding::Verdict;

std::string origin_text(const std::filesystem::path& file) {
  const std::string maker = read_maker(file);
  if (maker.empty()) return "its origin is unknown";
  std::vector<std::string> names;
  for (const Origin& origin : read_origins(file)) names.push_back(origin.name);
  if (names.empty()) return fmt::format("made by {}", maker);
  return fmt::format("made by {} from {}", maker, fmt::join(names, ", "));
}

/// Says of each calibration file who made it from what, and of those that no longer hold why.
std::vector<Finding> examine_files(const CellSettings& cell) {
  std::vector<Finding> findings;
  const std::vector<StaleFile> stale = stale_files(cell, true);
  for (const auto& [path, program] : {std::pair{cell.camera_model, "planar-calibrate-camera"},
                                      {cell.workplane, "planar-pair-tracker"},
                                      {cell.tool, "planar-pair-tracker"},
                                      {cell.error_map, "planar-fit-error-map"}}) {
    const std::string name = path.filename().string();
    if (!std::filesystem::exists(path))
      findings.push_back({Verdict::kDoubtful, name, "does not exist yet",
                          fmt::format("make it with {}", program)});
    else
      findings.push_back({Verdict::kWell, name, origin_text(path)});
    for (const StaleFile& file : stale) {
      if (file.path != path) continue;
      findings.back().verdict = Verdict::kFaulty;
      findings.push_back({Verdict::kFaulty, name, file.refusal.fault, file.refusal.remedy});
    }
  }
  return findings;
}

}  // namespace

std::vector<Finding> examine_cell(const std::filesystem::path& cell_file) {
  const CellSettings cell = read_cell(cell_file);
  require_devices(cell);
  std::vector<Finding> findings{
      {Finding::Verdict::kWell, "cell file", cell_file.string() + " is in order"}};
  for (Finding& finding : examine_files(cell)) findings.push_back(std::move(finding));
  for (Finding& finding : cell.drives[0].kind->examine(cell))
    findings.push_back(std::move(finding));
  for (Finding& finding : cell.camera.kind->examine(cell)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace planar
