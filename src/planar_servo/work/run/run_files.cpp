#include "planar_servo/work/run/run_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <system_error>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/cell_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Results are written to the nanometre.
constexpr double kSamePlace_m = 1e-9;
/// Directions are written to the millionth of a degree.
constexpr double kSameDirection_rad = 1e-6 * kDegree;

constexpr char kServoRemark[] = "# servo: ";

/// Throws unless the run was begun with the present files. One that does not name its files is
/// continued.
void require_same_origins(const fs::path& results, const std::vector<Origin>& present) {
  const std::vector<Origin> begun = read_origins(results);
  const auto same = [](const Origin& a, const Origin& b) {
    return a.role == b.role && a.sha256 == b.sha256;
  };
  if (begun.empty() || std::equal(begun.begin(), begun.end(), present.begin(), present.end(), same))
    return;
  const auto names = [](const std::vector<Origin>& origins) {
    std::vector<std::string> texts;
    texts.reserve(origins.size());
    for (const Origin& origin : origins)
      texts.push_back(fmt::format("{} {}", origin.name, origin.sha256.substr(0, 8)));
    return fmt::format("{}", fmt::join(texts, ", "));
  };
  throw InputError({fmt::format("the run was begun with {}; now it would continue with {}",
                                names(begun), names(present)),
                    "use the same files and options, or name another folder", results,
                    Cause::kForeign});
}

/// Returns what decides how a target is reached, besides the calibration files.
std::string settings_text(const ServoRequest& request) {
  return fmt::format("{}, centre: {}", servo_text(request.cell->settings.servo),
                     name_in(kCenterMethods, request.policy.center));
}

/// Throws unless the run was begun with the present settings. One that does not name its settings
/// is continued.
void require_same_settings(const fs::path& results, const std::string& present) {
  const std::string begun = remark_in(results, kServoRemark);
  if (begun.empty() || begun == present) return;
  throw InputError(
      {fmt::format("the run was begun with the servo settings {}; now it would continue with {}",
                   begun, present),
       "use the same settings, or name another folder", results, Cause::kForeign});
}

/// Returns whether a run was begun in this folder, even if it was killed before its first result.
bool holds_begun_run(const fs::path& folder) {
  if (fs::is_directory(folder) && fs::is_empty(folder)) return true;
  for (const char* table : {"results.csv", "steps.csv", "judge.csv"})
    if (fs::exists(folder / table)) return true;
  return false;
}

/// Returns the results without those of doubted targets, which are to be visited again, and removes
/// their rows from the table.
std::vector<TargetResult> without_doubted(const ServoRequest& request,
                                          std::vector<TargetResult> results) {
  const auto doubted = std::remove_if(
      results.begin(), results.end(),
      [](const TargetResult& result) { return result.status == ServoStatus::kDoubted; });
  if (doubted == results.end()) return results;
  results.erase(doubted, results.end());
  write_results(results_file(request), results_header(run_remarks(request)), results);
  return results;
}

}  // namespace

RunFolder::RunFolder(const fs::path& folder, const std::vector<const char*>& files)
    : exceptions_(std::uncaught_exceptions()) {
  for (const char* file : files)
    if (!fs::exists(folder / file)) made_.push_back(folder / file);
  const fs::path whole = fs::absolute(folder).lexically_normal();
  for (fs::path at = whole; !fs::exists(at) && at.has_relative_path(); at = at.parent_path())
    made_.push_back(at);
}

RunFolder::~RunFolder() {
  if (std::uncaught_exceptions() <= exceptions_) return;
  std::error_code error;
  for (const fs::path& path : made_) fs::remove(path, error);
}

fs::path results_file(const ServoRequest& request) {
  return request.folder.path / "results.csv";
}

std::vector<Origin> run_origins(const ServoRequest& request) {
  std::vector<Origin> origins;
  const CellSettings& cell = request.cell->settings;
  for (const MadeFile& file : calibration_files(cell, uses_error_map(*request.cell)))
    origins.push_back(origin_of(file));
  if (cell.arm_found) origins.push_back(origin_of({Role::kArmFound, *cell.arm_found}));
  for (const auto& [name, tip] : cell.tools)
    if (fs::exists(tip)) origins.push_back(origin_of({Role::kToolTip, tip}));
  return origins;
}

std::vector<std::string> run_remarks(const ServoRequest& request) {
  std::vector<std::string> remarks = csv_remarks(run_origins(request));
  remarks.push_back(kServoRemark + settings_text(request));
  return remarks;
}

const fs::path& folder_for(const ServoRequest& request) {
  if (request.folder.resume && !holds_begun_run(request.folder.path))
    throw InputError({"holds no run to resume",
                      "name the folder of one, or leave out --resume to begin one there",
                      request.folder.path, Cause::kMissing});
  // A run would overwrite the path's report.
  const fs::path looks = request.folder.path / "path_looks.csv";
  if (fs::exists(looks))
    throw InputError(
        {"the folder holds the run of a path", "name another folder", looks, Cause::kExists});
  make_folder(request.folder.path);
  require_writable(request.folder.path / "run.yaml", "run");
  require_writable(request.folder.path / "report.html", "page");
  return request.folder.path;
}

std::vector<TargetResult> results_so_far(const ServoRequest& request) {
  const fs::path results = results_file(request);
  if (!fs::exists(results) || fs::is_empty(results)) return {};
  if (!request.folder.resume)
    throw InputError(
        {"holds a run already", "name another folder or add --resume", results, Cause::kExists});
  drop_torn_line(results, results_header());
  require_same_origins(results, run_origins(request));
  require_same_settings(results, settings_text(request));
  return without_doubted(request, read_results(results));
}

RunFiles::RunFiles(const ServoRequest& request)
    : folder(request.folder.path, {"steps.csv", "results.csv"}),
      lock(folder_for(request)),
      begun(results_so_far(request)),
      table_file(results_file(request)),
      table_header(results_header(run_remarks(request))),
      steps(request.folder.path / "steps.csv", steps_header()),
      table(table_file, table_header) {}

void require_same_goal(const std::string& id, const TipPose& goal,
                       const std::vector<TargetResult>& results) {
  for (const TargetResult& result : results) {
    if (result.id != id) continue;
    if ((result.p_d - goal.p).norm() > kSamePlace_m)
      throw InputError(
          {fmt::format("target '{}' is at {} now; the run to resume has a result of it at {}", id,
                       place_mm(goal.p), place_mm(result.p_d)),
           "name another folder, or another id for the new place", "", Cause::kForeign});
    if (result.phi_d && std::abs(wrap_angle(*result.phi_d - goal.phi)) > kSameDirection_rad)
      throw InputError({fmt::format("target '{}' has the direction {:.6f} degrees now; the run to "
                                    "resume has a result of it at {:.6f} degrees",
                                    id, goal.phi / kDegree, *result.phi_d / kDegree),
                        "name another folder, or another id for the new direction", "",
                        Cause::kForeign});
  }
}

}  // namespace planar
