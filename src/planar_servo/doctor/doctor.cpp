#include "planar_servo/doctor/doctor.h"

#include <fmt/format.h>

#include <utility>

#include "planar_servo/files/provenance.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

namespace {

using Verdict = Finding::Verdict;

std::string made_from(const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const Origin& origin : read_origins(file)) names.push_back(origin.name);
  return names.empty() ? "its origin is unknown"
                       : fmt::format("made from {}", fmt::join(names, ", "));
}

/// Says of each calibration file what it was made from, and of those that no longer hold why.
std::vector<Finding> examine_files(const CellSettings& cell) {
  std::vector<Finding> findings;
  for (const auto& [file, program] : {std::pair{cell.camera_model, "planar-calibrate-camera"},
                                      {cell.workplane, "planar-pair-tracker"},
                                      {cell.tool, "planar-pair-tracker"},
                                      {cell.error_map, "planar-fit-error-map"}}) {
    const std::string name = file.filename().string();
    if (std::filesystem::exists(file))
      findings.push_back({Verdict::kWell, name, made_from(file)});
    else
      findings.push_back({Verdict::kDoubtful, name, "does not exist yet",
                          fmt::format("make it with {}", program)});
  }
  for (const Refusal& stale : stale_files(cell, true))
    findings.push_back({Verdict::kFaulty, "origins", stale.fault, stale.remedy});
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
