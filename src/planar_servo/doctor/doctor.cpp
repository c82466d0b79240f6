#include "planar_servo/doctor/doctor.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/doctor/camera_field.h"
#include "planar_servo/files/map/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/format/checksum.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/plausibility.h"

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

Finding examine_file(const MadeFile& file, bool is_stale) {
  const std::string name = file.path.filename().string();
  if (!std::filesystem::exists(file.path))
    return {Verdict::kDoubtful, name, "does not exist yet",
            fmt::format("make it with {}", program_for(file.role))};
  return {is_stale ? Verdict::kFaulty : Verdict::kWell, name, origin_text(file.path)};
}

std::vector<Finding> examine_checksum(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  const auto change = later_change(file, read_file(file));
  if (!change) return {};
  return {{Verdict::kFaulty, file.filename().string(), change->fault, change->remedy}};
}

/// Says what the fit of the cell's error map says against it.
std::vector<Finding> examine_map(const CellSettings& cell) {
  if (!std::filesystem::exists(cell.error_map)) return {};
  const std::string name = cell.error_map.filename().string();
  try {
    const auto against = objection(read_map(cell.error_map).quality);
    if (!against) return {};
    return {{Verdict::kFaulty, name, *against,
             "record more places and fit again; planar-servo moves by it only with --accept-map"}};
  } catch (const InputError& error) {
    return {{Verdict::kFaulty, name, error.what(), "make it anew with planar-fit-error-map"}};
  }
}

/// Says of each calibration file who made it from what, and of those that no longer hold why.
std::vector<Finding> examine_files(const CellSettings& cell) {
  std::vector<Finding> findings;
  const std::vector<StaleFile> all_stale = stale_files(cell, true);
  for (const MadeFile& file : made_files(cell, true)) {
    std::vector<Finding> reasons = examine_checksum(file.path);
    if (reasons.empty() && file.role == Role::kErrorMap) reasons = examine_map(cell);
    for (const StaleFile& stale : all_stale)
      if (stale.path == file.path)
        reasons.push_back({Verdict::kFaulty, file.path.filename().string(), stale.refusal.fault,
                           stale.refusal.remedy});
    findings.push_back(examine_file(file, !reasons.empty()));
    findings.insert(findings.end(), reasons.begin(), reasons.end());
  }
  return findings;
}

}  // namespace

std::vector<Finding> examine_cell(const std::filesystem::path& cell_file) {
  const CellSettings cell = read_cell(cell_file);
  require_devices(cell);
  std::vector<Finding> findings{
      {Finding::Verdict::kWell, "cell file", cell_file.string() + " is in order"}};
  for (Finding& finding : question_values(cell)) findings.push_back(std::move(finding));
  for (Finding& finding : examine_files(cell)) findings.push_back(std::move(finding));
  for (Finding& finding : question_camera_field(cell)) findings.push_back(std::move(finding));
  for (Finding& finding : cell.drives[0].kind->examine(cell))
    findings.push_back(std::move(finding));
  for (Finding& finding : cell.camera.kind->examine(cell)) findings.push_back(std::move(finding));
  for (Finding& finding : cell.tracker.kind->examine(cell)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace planar
