#include "planar_servo/console/doctor/work_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/console/doctor/doctor.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::vector<MadeFile> existing(std::vector<MadeFile> files) {
  files.erase(std::remove_if(files.begin(), files.end(),
                             [](const MadeFile& file) { return !fs::exists(file.path); }),
              files.end());
  return files;
}

}  // namespace

WorkFiles::WorkFiles(const fs::path& cell_file, std::string board)
    : cell_(read_cell(cell_file)), board_(std::move(board)), folder_(cell_file.parent_path()) {
  require_devices(cell_);
  findings_ = examine_files(cell_);
  lamps_ = beside(name_of(Role::kLamps, "lamps.csv"));
  pairs_ = beside(name_of(Role::kPairs, "pairs.csv"));
  stale_ = stale_by_tables();
}

std::string WorkFiles::name_of(Role role, const char* otherwise) const {
  for (const MadeFile& file : existing(made_files(cell_, true)))
    for (const Origin& origin : read_origins(file.path))
      if (origin.role == role) return origin.name;
  return otherwise;
}

/// Returns the files that were made from other tables than those that are there now, and a table of
/// lamps that planar-pair-tracker would refuse.
std::vector<StaleFile> WorkFiles::stale_by_tables() const {
  const std::vector<MadeFile> tables = existing({{Role::kFrames, recording() / "frames.csv"},
                                                 {Role::kTracker, recording() / "tracker.csv"},
                                                 {Role::kLamps, lamps_},
                                                 {Role::kPairs, pairs_}});
  std::vector<Origin> present;
  for (const std::vector<MadeFile>& files : {tables, anchors()})
    for (const MadeFile& file : files) present.push_back(origin_of(file));
  std::vector<MadeFile> made = made_files(cell_, true);
  made.push_back({Role::kPairs, pairs_});
  std::vector<StaleFile> stale = contradictions(
      existing(std::move(made)), present,
      {Role::kFrames, Role::kTracker, Role::kLamps, Role::kPairs, Role::kBar, Role::kMarks});
  for (const Origin& origin : origins_in(cell_, {{Role::kCamera, cell_.camera_model}}))
    present.push_back(origin);
  for (StaleFile& lamps :
       contradictions(existing({{Role::kLamps, lamps_}}), present,
                      {Role::kCamera, Role::kFrames, Role::kLampLayout, Role::kImageSize}))
    stale.push_back(std::move(lamps));
  return stale;
}

std::vector<MadeFile> WorkFiles::anchors() const {
  return existing({{Role::kBar, beside("bar.csv")}, {Role::kMarks, beside("marks.csv")}});
}

std::optional<std::string> WorkFiles::reason_of(const std::vector<fs::path>& files) const {
  for (const fs::path& file : files) {
    if (!fs::exists(file)) return file.string() + " does not exist yet";
    for (const Finding& finding : findings_)
      if (finding.where == file.filename().string() &&
          finding.verdict == Finding::Verdict::kFaulty && !finding.remedy.empty())
        return fmt::format("{}; {}", finding.fault, finding.remedy);
    if (auto stale = stale_by_table(file)) return stale;
  }
  return std::nullopt;
}

std::optional<std::string> WorkFiles::stale_by_table(const fs::path& file) const {
  for (const StaleFile& stale : stale_)
    if (stale.path == file) return stale.text();
  return std::nullopt;
}

std::string WorkFiles::description(const fs::path& file) const {
  for (const Finding& finding : findings_)
    if (finding.where == file.filename().string())
      return fmt::format("{}, {}", file.string(),
                         finding.fault.substr(0, finding.fault.find(" from ")));
  return fs::exists(file) ? file.string() : "all that is made from it is there";
}

std::vector<fs::path> WorkFiles::series(const std::string& stem, const std::string& ending) const {
  std::vector<fs::path> found;
  fs::path name = beside(stem + ending);
  for (int number = 2; fs::exists(name); ++number) {
    found.push_back(name);
    name = beside(fmt::format("{}_{}{}", stem, number, ending));
  }
  return found;
}

std::vector<fs::path> WorkFiles::folders(const std::string& stem) const {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(beside(".")))
    if (entry.is_directory() && entry.path().filename().string().rfind(stem, 0) == 0)
      found.push_back(beside(entry.path().filename().string()));
  std::sort(found.begin(), found.end());
  return found;
}

fs::path WorkFiles::next_of(const std::string& stem, const std::string& ending) const {
  const std::size_t count = series(stem, ending).size();
  return beside(count == 0 ? stem + ending : fmt::format("{}_{}{}", stem, count + 1, ending));
}

bool WorkFiles::is_recorded() const {
  return !holds_no_row(recording() / "frames.csv", frames_header());
}

std::size_t WorkFiles::unrecorded(const fs::path& plan) const {
  std::set<std::string> recorded;
  if (is_recorded())
    for (const FrameRow& frame : read_frames(recording())) recorded.insert(frame.id);
  const std::vector<PlanRow> rows = read_plan(plan, cell_.tool_orientation);
  return static_cast<std::size_t>(std::count_if(
      rows.begin(), rows.end(), [&](const PlanRow& row) { return recorded.count(row.id) == 0; }));
}

bool WorkFiles::is_run_of_now(const fs::path& run) const {
  const fs::path results = run / "results.csv";
  if (!fs::exists(run / "run.yaml") || !fs::exists(results)) return false;
  const std::string about = read_file(run / "run.yaml");
  const bool by_truth = about.find("_truth:") != about.npos;  // only a virtual cell has one
  if (about.find("error_map_used: false") != about.npos || by_truth != cell_.truth.has_value())
    return false;
  return are_results_of_now(results);
}

bool WorkFiles::are_results_of_now(const fs::path& results) const {
  std::vector<MadeFile> files = calibration_files(cell_, true);
  if (cell_.arm_found) files.push_back({Role::kArmFound, *cell_.arm_found});
  return contradictions({{Role::kPairs, results}}, origins_in(cell_, files), values_of(kRoles))
      .empty();
}

bool WorkFiles::is_certificate_to_continue(const fs::path& certificate) const {
  const fs::path cycles = certificate / "cycles.csv", results = certificate / "results.csv";
  if (fs::exists(certificate / "certificate.json")) return false;
  if (!fs::exists(cycles)) return !fs::exists(results);
  return remark_in(cycles, "# cell: ") == content_sha256(cell_.file) &&
         (!fs::exists(results) || are_results_of_now(results));
}

bool WorkFiles::is_certificate_of_now(const fs::path& certificate) const {
  const fs::path figures = certificate / "certificate.json";
  if (!fs::exists(figures)) return false;
  const auto json = nlohmann::json::parse(read_file(figures), nullptr, false);
  if (!json.is_object() || !json.contains("files")) return false;
  const std::string certified = json["files"].dump();
  const std::vector<MadeFile> files = calibration_files(cell_, true);
  return std::all_of(files.begin(), files.end(), [&](const MadeFile& file) {
    return fs::exists(file.path) && certified.find(content_sha256(file.path)) != std::string::npos;
  });
}

}  // namespace planar
