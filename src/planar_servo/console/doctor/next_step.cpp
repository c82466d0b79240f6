#include "planar_servo/console/doctor/next_step.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/console/doctor/doctor.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/plausibility.h"
#include "planar_servo/work/workpiece/bar_places.h"

namespace planar {

namespace {

namespace fs = std::filesystem;

/// Why a step is to be done; empty when it is not.
using Reason = std::optional<std::string>;
using State = WorkStep::State;

constexpr int kFirstReadings = 200;  // those of the timetable in doc/afternoon.md
constexpr int kMoreReadings = 40;
// Those of README.md's figures without a tracker.
constexpr int kPosesAlone = 1000, kLaysAlone = 12;

std::vector<MadeFile> existing(std::vector<MadeFile> files) {
  files.erase(std::remove_if(files.begin(), files.end(),
                             [](const MadeFile& file) { return !fs::exists(file.path); }),
              files.end());
  return files;
}

/// Returns the figures of a certificate that did not end before its last move; else null.
nlohmann::json figures_of(const fs::path& certificate) {
  const fs::path file = certificate / "certificate.json";
  if (!fs::exists(file)) return nullptr;
  auto json = nlohmann::json::parse(read_file(file), nullptr, false);
  const bool is_whole = !json.is_object() || !json.contains("ended_by") || json["ended_by"] == "" ||
                        json["ended_by"].is_null();
  return is_whole ? json : nullptr;
}

/// Knows the files of the work on a cell, those that the cell file names and those beside it, and
/// tells which of them are missing or no longer valid.
class WorkFiles {
 public:
  /// Throws InputError for a cell file with faults, and for devices that do not go together.
  WorkFiles(const fs::path& cell_file, std::string board)
      : cell_(read_cell(cell_file)), board_(std::move(board)), folder_(cell_file.parent_path()) {
    require_devices(cell_);
    findings_ = examine_files(cell_);
    lamps_ = beside(name_of(Role::kLamps, "lamps.csv"));
    pairs_ = beside(name_of(Role::kPairs, "pairs.csv"));
    stale_ = stale_by_tables();
  }

  const CellSettings& cell() const { return cell_; }
  /// The calibration board, as --grid takes it.
  const std::string& board() const { return board_; }
  fs::path beside(const std::string& name) const { return folder_ / name; }
  fs::path recording() const { return beside("recording"); }
  /// The table of lamps, as it was called when the calibration was made from it.
  fs::path lamps() const { return lamps_; }
  fs::path pairs() const { return pairs_; }

  /// Returns the drawings of a bar and of the base's marks that lie beside the cell file.
  std::vector<MadeFile> anchors() const {
    return existing({{Role::kBar, beside("bar.csv")}, {Role::kMarks, beside("marks.csv")}});
  }

  /// Returns why the first of these files that is missing, faulty or no longer valid is so.
  Reason reason_of(const std::vector<fs::path>& files) const {
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

  /// Returns why a file was made from other tables than those that are there now.
  Reason stale_by_table(const fs::path& file) const {
    for (const StaleFile& stale : stale_)
      if (stale.path == file) return stale.text();
    return std::nullopt;
  }

  /// Returns the file and, for one of the calibration, the program that made it and when.
  std::string description(const fs::path& file) const {
    for (const Finding& finding : findings_)
      if (finding.where == file.filename().string())
        return fmt::format("{}, {}", file.string(),
                           finding.fault.substr(0, finding.fault.find(" from ")));
    return fs::exists(file) ? file.string() : "all that is made from it is there";
  }

  /// Returns those of STEM, STEM_2, STEM_3, ... that there are beside the cell file.
  std::vector<fs::path> series(const std::string& stem, const std::string& ending = "") const {
    std::vector<fs::path> found;
    fs::path name = beside(stem + ending);
    for (int number = 2; fs::exists(name); ++number) {
      found.push_back(name);
      name = beside(fmt::format("{}_{}{}", stem, number, ending));
    }
    return found;
  }

  /// Returns the folders beside the cell file whose names begin with STEM, those of the page, too.
  std::vector<fs::path> folders(const std::string& stem) const {
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(beside(".")))
      if (entry.is_directory() && entry.path().filename().string().rfind(stem, 0) == 0)
        found.push_back(beside(entry.path().filename().string()));
    std::sort(found.begin(), found.end());
    return found;
  }

  /// Returns the first of the series that there is not.
  fs::path next_of(const std::string& stem, const std::string& ending = "") const {
    const std::size_t count = series(stem, ending).size();
    return beside(count == 0 ? stem + ending : fmt::format("{}_{}{}", stem, count + 1, ending));
  }

  bool is_recorded() const { return !holds_no_row(recording() / "frames.csv", frames_header()); }

  /// Returns how many rows of a plan the recording lacks. Throws InputError for a faulty plan.
  std::size_t unrecorded(const fs::path& plan) const {
    std::set<std::string> recorded;
    if (is_recorded())
      for (const FrameRow& frame : read_frames(recording())) recorded.insert(frame.id);
    const std::vector<PlanRow> rows = read_plan(plan, cell_.tool_orientation);
    return static_cast<std::size_t>(std::count_if(
        rows.begin(), rows.end(), [&](const PlanRow& row) { return recorded.count(row.id) == 0; }));
  }

  /// Returns whether the folder of a run was made with the calibration as it is now.
  bool is_run_of_now(const fs::path& run) const {
    const fs::path results = run / "results.csv";
    if (!fs::exists(run / "run.yaml") || !fs::exists(results)) return false;
    const std::string about = read_file(run / "run.yaml");
    const bool by_truth = about.find("_truth:") != about.npos;  // only a virtual cell has one
    if (about.find("error_map_used: false") != about.npos || by_truth != cell_.truth.has_value())
      return false;
    return are_results_of_now(results);
  }

  /// Returns whether the cell file and calibration of now can continue the certificate of a folder.
  bool is_certificate_to_continue(const fs::path& certificate) const {
    const fs::path cycles = certificate / "cycles.csv", results = certificate / "results.csv";
    if (!figures_of(certificate).is_null()) return false;
    if (!fs::exists(cycles)) return !fs::exists(results);
    return remark_in(cycles, "# cell: ") == content_sha256(cell_.file) &&
           (!fs::exists(results) || are_results_of_now(results));
  }

  /// Returns whether the folder of a certificate is about the calibration as it is now.
  bool is_certificate_of_now(const fs::path& certificate) const {
    const nlohmann::json json = figures_of(certificate);
    if (!json.is_object() || !json.contains("files")) return false;
    const std::string certified = json["files"].dump();
    const std::vector<MadeFile> files = calibration_files(cell_, true);
    return std::all_of(files.begin(), files.end(), [&](const MadeFile& file) {
      return fs::exists(file.path) &&
             certified.find(content_sha256(file.path)) != std::string::npos;
    });
  }

 private:
  bool are_results_of_now(const fs::path& results) const {
    std::vector<MadeFile> files = calibration_files(cell_, true);
    if (cell_.arm_found) files.push_back({Role::kArmFound, *cell_.arm_found});
    return contradictions({{Role::kPairs, results}}, origins_in(cell_, files), values_of(kRoles))
        .empty();
  }

  std::string name_of(Role role, const char* otherwise) const {
    for (const MadeFile& file : existing(made_files(cell_, true)))
      for (const Origin& origin : read_origins(file.path))
        if (origin.role == role) return origin.name;
    return otherwise;
  }

  /// Returns the files that were made from other tables than those that are there now, and a table
  /// of lamps that planar-pair-tracker would refuse.
  std::vector<StaleFile> stale_by_tables() const {
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

  CellSettings cell_;
  std::string board_;
  fs::path folder_, lamps_, pairs_;
  std::vector<Finding> findings_;
  std::vector<StaleFile> stale_;
};

WorkStep step(const std::string& name, const Reason& reason, const std::string& done,
              const std::string& command) {
  if (!reason) return {State::kDone, name, done};
  return {State::kOpen, name, *reason, command};
}

WorkStep calculated(WorkStep step) {
  step.is_calculated = true;
  return step;
}

std::string command(const WorkFiles& work, const char* program, const std::string& rest) {
  return fmt::format("{} --cell {}{}", program, shell_word(work.cell().file), rest);
}

/// A value that is doubtful may be meant, and holds nothing up.
WorkStep cell_step(const WorkFiles& work) {
  const std::string file = work.cell().file.string();
  const std::vector<Finding> doubts = question_values(work.cell());
  return {State::kDone, "cell file",
          doubts.empty() ? file + " is in order"
                         : fmt::format("doubtful in {}: {} {}; planar-doctor says more", file,
                                       doubts[0].where, doubts[0].fault)};
}

/// Returns whether readings of a tracker tell the error, perhaps written by its own software; else
/// lays of a board and poses do.
bool has_tracker(const WorkFiles& work) {
  return work.cell().tracker.kind->measures() || !work.cell().datum.empty();
}

/// Returns the options by which a bar and marks of the base enter the fit.
std::string anchor_options(const WorkFiles& work) {
  std::string options;
  const fs::path marks = work.beside("marks.csv");
  if (fs::exists(work.beside("bar.csv"))) options += " --bar " + shell_word(work.beside("bar.csv"));
  if (fs::exists(marks)) options += " --marks " + shell_word(marks);
  if (options.empty()) return options;
  return options + " --image " + shell_word(work.beside("bar")) + "/*.png";
}

/// Fits the map or, where the fit to the present pairs has rejected it, plans more places first.
std::string map_command(const WorkFiles& work) {
  const CellSettings& cell = work.cell();
  try {
    if (fs::exists(cell.error_map) && !work.stale_by_table(cell.error_map) &&
        objection(read_map(cell.error_map).quality))
      return command(
          work, "planar-plan",
          fmt::format(" --readings {} --after {} -o {}", kMoreReadings, shell_word(work.pairs()),
                      shell_word(work.next_of("plan", ".csv"))));
  } catch (const InputError&) {
    // One that cannot be read is fitted again.
  }
  return command(
      work, "planar-fit-error-map",
      fmt::format("{}{} --arm-out {} -o {} {}",
                  has_tracker(work) ? "" : " --lays " + shell_word(work.beside("lays.csv")),
                  anchor_options(work),
                  shell_word(cell.arm_found.value_or(work.beside("arm.yaml"))),
                  shell_word(cell.error_map), shell_word(work.pairs())));
}

WorkStep map_step(const WorkFiles& work) {
  std::vector<fs::path> files{work.cell().error_map};
  if (work.cell().arm_found) files.push_back(*work.cell().arm_found);
  Reason reason = work.stale_by_table(files[0]);
  if (!reason) reason = work.reason_of(files);
  for (const MadeFile& anchor : work.anchors())
    if (!reason && find_role(read_origins(files[0]), anchor.role) == nullptr)
      reason = fmt::format("{} was made without {}", files[0].string(), anchor.path.string());
  return step("error map", reason, work.description(files[0]), reason ? map_command(work) : "");
}

/// `is_read`: the map needs the pairs. Without a tracker a person measures how thick the board is.
WorkStep pair_step(const WorkFiles& work, bool is_read) {
  const CellSettings& cell = work.cell();
  std::vector<fs::path> files{cell.workplane, cell.tool};
  if (cell.health) files.push_back(*cell.health);
  if (is_read || fs::exists(work.pairs())) files.push_back(work.pairs());
  std::string rest = cell.health ? " --health-out " + shell_word(*cell.health) : "";
  Reason reason = work.reason_of(files);
  if (!has_tracker(work)) {
    rest += fmt::format(" --workplane-from grid --grid {} --board-thickness-mm T --lays-out {}",
                        shell_word(work.board()), shell_word(work.beside("lays.csv")));
    if (reason)
      *reason +=
          "; put for T by how far the board's dots lie above the lamps' plane, negative below";
  }
  return step(
      "pairs", reason, work.description(files[0]),
      command(work, "planar-pair-tracker",
              fmt::format(" --lamps {} --recording {} --workplane-out {} --tool-out {}{} -o {}",
                          shell_word(work.lamps()), shell_word(work.recording()),
                          shell_word(cell.workplane), shell_word(cell.tool), rest,
                          shell_word(work.pairs()))));
}

/// A person lays a bar of certified length, whose pictures show the marks of the base, too; without
/// a bar one picture does.
std::optional<WorkStep> anchor_step(const WorkFiles& work, bool is_read) {
  if (work.anchors().empty()) return std::nullopt;
  const bool has_bar = fs::exists(work.beside("bar.csv"));
  const fs::path pictures = work.beside("bar");
  const std::size_t wanted = has_bar ? kBarPlaces : 1;
  const std::size_t there =
      has_bar ? bar_pictures(pictures).size() : fs::exists(pictures / "marks.png");
  const std::string folder = shell_word(pictures);
  Reason reason;
  if (is_read && there < wanted)
    reason = fmt::format("{} of {} pictures of {} are taken", there, wanted,
                         work.anchors().front().path.string());
  return step("bar and marks", reason, fmt::format("{} pictures in {}", there, folder),
              has_bar ? command(work, "planar-record",
                                fmt::format(" --bar {} --out {}",
                                            shell_word(work.beside("bar.csv")), folder))
                      : fmt::format("(mkdir -p {0} && cd {0} && echo save marks.png | "
                                    "planar-jog --cell ../{1})",
                                    folder, shell_word(work.cell().file.filename())));
}

WorkStep lamp_step(const WorkFiles& work, bool is_read) {
  Reason reason;
  if (is_read || fs::exists(work.lamps())) reason = work.reason_of({work.lamps()});
  return step(
      "lamps", reason, work.description(work.lamps()),
      command(work, "planar-locate-lamps",
              fmt::format(" -o {} {}", shell_word(work.lamps()), shell_word(work.recording()))));
}

WorkStep camera_step(const WorkFiles& work) {
  const fs::path& camera = work.cell().camera_model;
  return step("camera", work.reason_of({camera}), work.description(camera),
              fmt::format("planar-calibrate-camera --grid {} --model {} -o {} {}",
                          shell_word(work.board()), camera.extension() == ".xml" ? "visp" : "auto",
                          shell_word(camera), shell_word(work.recording())));
}

/// A person shows the board to a real cell's camera.
WorkStep recording_step(const WorkFiles& work, bool is_read) {
  Reason reason;
  fs::path plan = work.beside("plan.csv");
  if (is_read && !work.is_recorded()) reason = work.recording().string() + " does not exist yet";
  if (reason || work.is_recorded())
    for (const fs::path& there : work.series("plan", ".csv")) {
      const std::size_t count = work.unrecorded(there);
      if (count == 0) continue;
      plan = there;
      reason = fmt::format("{} rows of {} are not recorded yet", count, there.string());
    }
  if (reason && has_tracker(work) && !work.cell().tracker.kind->measures())
    *reason += "; state the tracker in " + work.cell().file.string() + " first";
  return step("recording", reason, work.description(work.recording()),
              command(work, "planar-record",
                      fmt::format(" --plan {}{} --out {}", shell_word(plan),
                                  work.cell().truth ? "" : " --grid " + shell_word(work.board()),
                                  shell_word(work.recording()))));
}

WorkStep plan_step(const WorkFiles& work, bool is_read) {
  const fs::path plan = work.beside("plan.csv");
  Reason reason;
  if (is_read) reason = work.reason_of({plan});
  const std::string amount =
      has_tracker(work)
          ? fmt::format("--readings {}", kFirstReadings)
          : fmt::format("--readings 0 --unattended {} --lays {}", kPosesAlone, kLaysAlone);
  return step("plan", reason, work.description(plan),
              command(work, "planar-plan", fmt::format(" {} -o {}", amount, shell_word(plan))));
}

/// The steps from plan to map. A step's files are needed while a later one that reads them is open.
std::vector<WorkStep> calibration_steps(const WorkFiles& work) {
  const auto is_open = [](const WorkStep& step) { return step.state == State::kOpen; };
  const WorkStep map = map_step(work);
  const std::optional<WorkStep> anchors = anchor_step(work, is_open(map));
  const WorkStep pairs = pair_step(work, is_open(map) || (anchors && is_open(*anchors)));
  const WorkStep lamps = lamp_step(work, is_open(pairs));
  const WorkStep camera = camera_step(work);
  const WorkStep recording =
      recording_step(work, is_open(camera) || is_open(lamps) || is_open(pairs));
  const WorkStep plan = plan_step(work, is_open(recording));
  std::vector<WorkStep> steps{calculated(plan), recording, calculated(camera), calculated(lamps),
                              has_tracker(work) ? calculated(pairs) : pairs};
  if (anchors) steps.push_back(*anchors);
  steps.push_back(calculated(map));
  return steps;
}

/// The arm that the fit found is used once the cell file names it.
WorkStep arm_step(const WorkFiles& work) {
  const CellSettings& cell = work.cell();
  const fs::path arm = work.beside("arm.yaml");
  Reason reason;
  if (!cell.arm_found && fs::exists(arm))
    reason = fmt::format("{} does not name {} yet", cell.file.string(), arm.string());
  else if (!cell.arm_found && !fs::exists(cell.error_map))
    reason = "it is found with the error map";
  return step(
      "found arm", reason,
      cell.arm_found ? work.description(*cell.arm_found) : "none, which the loop can do without",
      fmt::format("printf '\\narm_found: arm.yaml\\n' >>{}", shell_word(cell.file)));
}

/// The tools that the cell file names, if there are any.
std::optional<WorkStep> tool_step(const WorkFiles& work) {
  const CellSettings& cell = work.cell();
  for (const auto& [name, file] : cell.tools) try {
      CellTools(cell, name, false).with_tips({TargetRow{}});
    } catch (const InputError& error) {
      // One that was there is kept until its successor is.
      const fs::path out = fs::exists(file) ? work.next_of(file.stem().string(), ".yaml") : file;
      return step("tools",
                  fmt::format("tool '{}': {}{}", name, error.what(),
                              out == file ? "" : "; name the new file in the cell file, too"),
                  "", command(work, "planar-teach-tool", " -o " + shell_word(out)));
    }
  if (cell.tools.empty()) return std::nullopt;
  return WorkStep{State::kDone, "tools", fmt::format("{} taught", cell.tools.size())};
}

/// The workpiece whose drawing lies beside the cell file, if there is one.
std::optional<WorkStep> workpiece_step(const WorkFiles& work) {
  const fs::path drawing = work.beside("work.csv"), found = work.beside("work.yaml");
  if (!fs::exists(drawing)) return std::nullopt;
  Reason reason;
  if (!fs::exists(found)) {
    reason = fmt::format("where the work of {} lies is not known yet", drawing.string());
  } else
    try {
      read_works(found);
      require_made_with({Role::kWork, found}, work_origins(work.cell(), drawing, true), false);
    } catch (const InputError& error) {
      reason = error.what();
    }
  return step("workpiece", reason, work.description(found),
              command(work, "planar-find-work",
                      fmt::format(" --drawing {} -o {}", shell_word(drawing), shell_word(found))));
}

/// Returns places that the arm reaches, on a work the three nearest to its middle, as drawn.
std::vector<Eigen::Vector2d> target_places(const WorkFiles& work, bool on_work) {
  std::vector<Eigen::Vector2d> places = reachable_places(work.cell());
  if (!on_work) return places;
  const FoundWork found = read_works(work.beside("work.yaml")).works.front();
  Eigen::AlignedBox2d marks;
  for (const FoundFiducial& mark : found.fiducials) marks.extend(mark.fiducial.p_W);
  for (Eigen::Vector2d& p : places) p = found.pose.A.inverse() * (p - found.pose.t);
  std::sort(places.begin(), places.end(), [&](const auto& a, const auto& b) {
    return (a - marks.center()).norm() < (b - marks.center()).norm();
  });
  places.resize(std::min<std::size_t>(places.size(), 3));
  return places;
}

/// Returns a command that writes three targets where the arm can go.
std::string target_command(const WorkFiles& work, bool on_work) {
  const std::vector<Eigen::Vector2d> places = target_places(work, on_work);
  constexpr const char* kNames[] = {"A", "B", "C"};
  std::string rows;
  for (std::size_t i = 0; i < std::size(kNames) && !places.empty(); ++i) {
    const Eigen::Vector2d& p = places[(2 * i + 1) * places.size() / (2 * std::size(kNames))];
    rows += fmt::format(" {},{:.0f},{:.0f}", kNames[i], mm(p.x()), mm(p.y()));
  }
  return fmt::format("printf '%s\\n' id,x_mm,y_mm{} >{}", rows,
                     shell_word(work.beside("targets.csv")));
}

/// Targets on a work can be named once that is found.
WorkStep target_step(const WorkFiles& work, const std::optional<WorkStep>& piece, bool is_read) {
  const fs::path targets = work.beside("targets.csv");
  const std::string as_drawn = piece ? ", in the coordinates of work.csv" : "";
  Reason reason;
  if (is_read && !fs::exists(targets))
    reason = targets.string() + " does not exist yet" +
             (piece ? as_drawn : "; planar-jog --teach writes one, too");
  const bool is_lost = piece && piece->state == State::kOpen;
  return step("targets", reason, work.description(targets) + as_drawn,
              is_lost ? "" : target_command(work, piece.has_value()));
}

WorkStep run_step(const WorkFiles& work) {
  Reason reason = "no run with this calibration yet";
  std::string done;
  for (const fs::path& run : work.folders("run"))
    if (work.is_run_of_now(run)) {
      reason.reset();
      done = run.string() + " is a run with this calibration";
    }
  const fs::path found = work.beside("work.yaml");
  const std::string on_work =
      fs::exists(work.beside("work.csv")) ? " --work " + shell_word(found) : "";
  return step("positioning", reason, done,
              command(work, "planar-servo",
                      fmt::format("{} --targets {} --out {}", on_work,
                                  shell_word(work.beside("targets.csv")),
                                  shell_word(work.next_of("run")))));
}

/// A certificate that was begun with the present files is continued.
WorkStep certificate_step(const WorkFiles& work) {
  if (!has_tracker(work) && !work.cell().truth)
    return {State::kDone, "certificate",
            "none, for which a tracker would have to judge the arm; planar-certify --by scale-bar "
            "tests lengths"};
  Reason reason = "no certificate of this calibration yet";
  fs::path out = work.next_of("certificate");
  std::string done;
  for (const fs::path& there : work.folders("certificate")) {
    if (work.is_certificate_to_continue(there)) out = there;
    if (!work.is_certificate_of_now(there)) continue;
    reason.reset();
    done = there.string() + " certifies this calibration";
  }
  return step("certificate", reason, done,
              command(work, "planar-certify", fmt::format(" --out {}", shell_word(out))));
}

constexpr Named<State> kStates[] = {
    {State::kDone, "done"}, {State::kNext, "next"}, {State::kOpen, "open"}};

}  // namespace

std::string shell_word(const fs::path& path) {
  std::string text = path.string();
  const bool is_plain = std::all_of(text.begin(), text.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 ||
           std::string_view("/._-+,:@").find(static_cast<char>(letter)) != std::string::npos;
  });
  if (is_plain) return text;
  std::string quoted = "'";
  for (const char letter : text) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
  return quoted + "'";
}

std::vector<WorkStep> work_steps(const fs::path& cell_file, const std::string& board) {
  const WorkFiles work(cell_file, board);
  std::vector<WorkStep> steps{cell_step(work)};
  for (WorkStep& calibration : calibration_steps(work)) steps.push_back(std::move(calibration));
  const WorkStep run = run_step(work);
  steps.push_back(calculated(arm_step(work)));
  const std::optional<WorkStep> piece = workpiece_step(work);
  for (const auto& optional : {tool_step(work), piece})
    if (optional) steps.push_back(*optional);
  steps.push_back(target_step(work, piece, run.state == State::kOpen));
  steps.push_back(run);
  steps.push_back(certificate_step(work));
  const auto next = std::find_if(steps.begin(), steps.end(),
                                 [](const WorkStep& step) { return step.state == State::kOpen; });
  if (next != steps.end()) next->state = State::kNext;
  return steps;
}

std::optional<WorkStep> next_step(const fs::path& cell_file, const std::string& board) {
  for (WorkStep& step : work_steps(cell_file, board))
    if (step.state == State::kNext) return std::move(step);
  return std::nullopt;
}

std::string steps_text(const std::vector<WorkStep>& steps) {
  std::string text;
  for (const WorkStep& step : steps) {
    text += fmt::format("{}  {:12} {}\n", name_in(kStates, step.state), step.name, step.what);
    if (step.state == State::kNext) text += "      " + step.command + "\n";
  }
  const bool is_done = std::all_of(steps.begin(), steps.end(),
                                   [](const WorkStep& step) { return step.state == State::kDone; });
  return is_done ? text + "nothing is left to do\n" : text;
}

nlohmann::json steps_json(const std::vector<WorkStep>& steps) {
  nlohmann::json rows = nlohmann::json::array();
  for (const WorkStep& step : steps)
    rows.push_back({{"state", name_in(kStates, step.state)},
                    {"step", step.name},
                    {"what", step.what},
                    {"command", step.command}});
  return {{"steps", rows}};
}

}  // namespace planar
