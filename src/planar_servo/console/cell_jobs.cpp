#include "planar_servo/console/cell_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>
#include <utility>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/work/run/cell_check.h"
#include "planar_servo/work/run/dry_run.h"
#include "planar_servo/work/run/servo_report.h"
#include "planar_servo/work/run/target_stream.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr char kTable[] = "the table";
constexpr std::size_t kMostName = 64;
/// A cell that was found well less long ago is moved in without another check.
constexpr double kWellFor_s = 600.0;

std::vector<TargetRow> targets_in(const std::string& csv, const std::string& where) {
  TargetLines lines(where);
  std::istringstream text(csv);
  std::vector<TargetRow> targets;
  Faults faults;
  for (std::string line; std::getline(text, line);) try {
      if (auto target = lines.next(line)) targets.push_back(std::move(*target));
    } catch (const InputError& e) {
      if (!lines.has_columns()) throw;
      for (const Refusal& refusal : e.refusals()) faults.add(refusal);
    }
  faults.throw_if_any();
  return targets;
}

/// Returns whether a file can be one of works, by its first lines: a large map takes long to read.
bool begins_as_works(const fs::path& file) {
  std::string head(256, ' ');
  std::ifstream(file).read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find("planar-servo/work/") != head.npos;
}

std::optional<Cause> cause_of(const std::exception& error) {
  if (const auto* work = dynamic_cast<const WorkError*>(&error)) return work->refusal().cause;
  if (const auto* input = dynamic_cast<const InputError*>(&error)) return input->refusal().cause;
  return std::nullopt;
}

}  // namespace

CellJobs::CellJobs(const KnownCell& cell, StateBoard& board, CellWorker& worker)
    : cell_(cell), board_(board), worker_(worker) {
  if (const auto job = board.state().job) last_job_ = job->id;
}

void CellJobs::load_targets(const std::string& csv, const std::string& work,
                            const std::string& tool) {
  Wanted wanted{targets_in(csv, kTable), work, tool};
  if (csv.find_first_not_of(" \r\n") != csv.npos && wanted.drawn.empty())
    throw InputError({"has no rows", "add a row id,x_mm,y_mm", kTable, Cause::kMissing});
  if (wanted.drawn.empty() && !(work.empty() && tool.empty()))
    throw InputError(
        {"has no rows for that work or tool", "add a row id,x_mm,y_mm", kTable, Cause::kMissing});
  if (!wanted.drawn.empty())
    question_targets(placed(wanted).targets, cell_.settings().workspace, kTable);
  const std::lock_guard<std::mutex> lock(mutex_);
  loaded_ = std::move(wanted);
}

CellJobs::Wanted CellJobs::wanted() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!loaded_.drawn.empty()) return loaded_;
  }
  const fs::path table = cell_.teach();
  if (!fs::exists(table)) return {};
  return {targets_in(read_file(table), table.filename().string())};
}

CellJobs::Placed CellJobs::placed(const Wanted& wanted) const {
  Placed placed{wanted.drawn, {}};
  if (!wanted.work.empty()) {
    const std::vector<std::string> known = works();
    if (std::find(known.begin(), known.end(), wanted.work) == known.end())
      throw InputError({fmt::format("'{}' is no file of works beside the cell file", wanted.work),
                        known.empty() ? "find one with planar-find-work"
                                      : fmt::format("there are {}", fmt::join(known, ", ")),
                        "work", Cause::kMissing});
    placed.works = read_works(cell_.folder() / wanted.work, cell_.calibrated(), false);
    placed.targets = on_works(placed.targets, placed.works->works);
  }
  placed.targets =
      CellTools(cell_.settings(), wanted.tool, false).with_tips(std::move(placed.targets));
  return placed;
}

std::vector<std::string> CellJobs::works() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(cell_.folder())) try {
      if (!entry.is_regular_file() || entry.path().extension() != ".yaml") continue;
      if (!begins_as_works(entry.path())) continue;
      read_works(entry.path());
      names.push_back(entry.path().filename().string());
    } catch (const InputError&) {
      // a file of another kind
    }
  std::sort(names.begin(), names.end());
  return names;
}

void CellJobs::take_taught(const std::string& id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  // It was taught in the base frame, for P.
  if (loaded_.drawn.empty() || !loaded_.work.empty() || !loaded_.tool.empty()) return;
  for (const TargetRow& target : targets_in(read_file(cell_.teach()), cell_.teach().string()))
    if (target.id == id) loaded_.drawn.push_back(target);
}

std::vector<nlohmann::ordered_json> CellJobs::results() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return results_;
}

int CellJobs::run(const std::string& name, bool resume, StopsKnown known) {
  const fs::path out = folder(name);
  const Wanted kept = wanted();
  const Placed on = placed(kept);
  if (on.targets.empty())
    throw InputError({"there are no targets", "load or teach some", "", Cause::kMissing});
  return begin(
      Doing::kRunning, "targets", name, known,
      [=](CellDevices& devices, const Stop& stop, const Begun& begun) -> Ending {
        ServoRequest wanted = request_for_targets(stop, out);
        wanted.folder.resume = resume;
        wanted.works = on.works;
        const FrameCounts before = devices.camera().counts();
        ServoRun run(wanted, devices, watch());
        for (const TargetRow& goal : on.targets) run.require_same(goal);
        begun(0, on.targets.size());
        const fs::path table = wanted.folder.path / "targets.csv";
        write_file(table, targets_text(kept.drawn));
        run_servo(run, on.targets, [&](std::size_t done, std::size_t all) {
          show_progress(done, all);
          tell_result(result_answer(run.results().back()));
        });
        for (const TargetResult& result : run.results())
          if (result.status == ServoStatus::kDoubted) tell_result(result_answer(result));
        const ServoFigures figures =
            conclude_run(wanted, run, devices.camera().counts() - before, table);
        hold(run.ended_by().value_or(""));
        return {reached_words(figures), figures.reached == figures.targets && !run.ended_by()};
      });
}

int CellJobs::go(const TargetRow& place, StopsKnown known) {
  const TargetRow target = placed({{place}}).targets.front();
  return begin(
      Doing::kRunning, "go", target.id, known,
      [=](CellDevices& devices, const Stop& stop, const Begun& begun) -> Ending {
        ServoRun run(request_for_targets(stop, {}), devices, watch());
        begun(0, 1);
        const TargetResult result = run.move_to(target);
        show_progress(1, 1, {});
        tell_result(result_answer(result));
        const bool ok = result.status == ServoStatus::kReached;
        return {ok ? "reached" : fmt::format("{}: {}", name(result.status), result.reason), ok};
      });
}

int CellJobs::check(StopsKnown known) {
  return begin(
      Doing::kChecking, "check", "", known,
      [this](CellDevices& devices, const Stop& stop, const Begun& begun) -> Ending {
        const CalibratedCell cell = read_checkable_cell(cell_.settings());
        begun(0, 0);
        const std::vector<HealthFinding> found = check_devices(cell, devices, refuse_homing, stop);
        note_findings(found);
        return {found.empty() ? "the cell is as it was at its calibration" : findings_text(found),
                found.empty()};
      });
}

int CellJobs::begin(Doing doing, const std::string& kind, const std::string& name, StopsKnown known,
                    const Work& work) {
  if (doing != Doing::kCalculating) require_able();
  auto begun = std::make_shared<std::promise<int>>();
  std::future<int> number = begun->get_future();
  const std::string text =
      fmt::format("{}{}", name_in(kDoings, doing), name.empty() ? "" : ": " + name);
  worker_.begin(
      doing, text, known,
      [=, begun = std::move(begun)](CellDevices& devices, const Stop& stop) -> CellWorker::Tell {
        bool is_begun = false;
        const auto begin_now = [&](std::size_t done, std::size_t all) {
          begun->set_value(begin_state({0, kind, name, done, all}));
          is_begun = true;
        };
        try {
          const Ending ending = work(devices, stop, begin_now);
          return [=] { end(ending); };
        } catch (const std::exception& error) {
          if (!is_begun)
            return [begun, fault = std::current_exception()] { begun->set_exception(fault); };
          // A stop by hand at the machine is none of these: it may have had a reason.
          const bool stopped = dynamic_cast<const StopRequested*>(&error) != nullptr;
          if (!stopped) hold(error.what());
          const Ending ending{error.what(), false, stopped ? "warning" : "error", cause_of(error)};
          return [=] { end(ending); };
        }
      });
  try {
    return number.get();
  } catch (const std::future_error&) {
    throw WorkError("was stopped before it began", Cause::kStopped);
  }
}

int CellJobs::begin_state(JobState job) {
  job.id = ++last_job_;
  first_.reset();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    results_.clear();
  }
  board_.change([&](CellState& state) {
    state.job = job;
    state.held_by.clear();
    state.recording.reset();
  });
  return job.id;
}

void CellJobs::hold(const std::string& reason) {
  if (!reason.empty()) forget_check();
  board_.change([&](CellState& state) { state.held_by = reason; });
}

void CellJobs::note_findings(const std::vector<HealthFinding>& found) {
  worker_.note_findings(
      each(found, [](const Refusal& finding) { return finding.at("the check of the cell"); }));
  const bool tolerable = std::none_of(found.begin(), found.end(), [](const HealthFinding& finding) {
    return finding.cost_m > kTolerable_m;
  });
  well_s_ = tolerable ? clock_.now_s() : kNever;
}

void CellJobs::end(const Ending& ending) {
  board_.change([&](CellState& state) {
    state.job->ended = ending.words;
    state.job->ok = ending.ok;
    state.job->cause = ending.cause;
    state.job->left_s.reset();
  });
  board_.tell_line(ending.level, ending.words);
}

void CellJobs::require_able() const {
  const auto arm = board_.state().arm;
  if (arm && !arm->to_do.empty())
    throw InputError({"the arm cannot move yet", arm->to_do, "", Cause::kDevice});
}

bool CellJobs::refuse_homing(Homing way, const std::string& unhomed) {
  throw DriveError({unhomed,
                    way == Homing::kMark
                        ? "turn them to their marks and mark them, then begin again"
                        : "home the arm, then begin again",
                    "", Cause::kDevice});
}

void CellJobs::require_name(const std::string& name, std::string_view marks, const char* where) {
  const bool is_allowed = std::all_of(name.begin(), name.end(), [&](unsigned char letter) {
    return std::isalnum(letter) != 0 || marks.find(static_cast<char>(letter)) != marks.npos;
  });
  if (is_allowed && !name.empty() && name.size() <= kMostName && name[0] != '.') return;
  throw InputError({fmt::format("is '{}'", name),
                    fmt::format("take up to {} letters, digits and {}", kMostName, marks), where});
}

fs::path CellJobs::folder(const std::string& name) const {
  require_name(name, "-_", "out");
  return cell_.folder() / name;
}

ServoRequest CellJobs::request(const Stop& stop) {
  ServoRequest request;
  request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell_.settings()));
  request.policy.center = cell_.settings().lamps.method;
  request.stop = stop;
  request.may_home = refuse_homing;
  request.checking = [this](const auto& places) {
    board_.change([&](CellState& state) { state.checking_B = places; });
  };
  request.found = [this](const auto& found) { note_findings(found); };
  const double ago_s = clock_.now_s() - well_s_;
  if (ago_s < kWellFor_s) request.policy.checked_s_ago = ago_s;
  return request;
}

ServoRequest CellJobs::request_for_targets(const Stop& stop, const fs::path& out) {
  ServoRequest wanted = request(stop);
  wanted.folder.path = out;
  wanted.policy.learns = cell_.settings().servo.learns;
  return wanted;
}

ServoRun::Observer CellJobs::watch() {
  return [this](const ServoSight& sight) {
    show_look(sight.step.measurement, sight.step.believed_p());
  };
}

void CellJobs::show_look(const TipMeasurement& seen, const Eigen::Vector2d& p_B) {
  if (!seen.ok()) return;
  worker_.pictures().aim(seen.lamps_px);
  board_.change([&](CellState& state) { state.seen_B = p_B; });
}

void CellJobs::show_progress(std::size_t done, std::size_t all, std::optional<double> left_s) {
  board_.change([&](CellState& state) {
    state.job->done = done;
    state.job->all = all;
    state.job->left_s = left_s;
  });
}

void CellJobs::show_progress(std::size_t done, std::size_t all) {
  const double now_s = clock_.now_s();
  if (!first_) first_ = {done, now_s};
  if (done <= first_->done) return show_progress(done, all, {});
  const double place_s = (now_s - first_->at_s) / static_cast<double>(done - first_->done);
  show_progress(done, all, place_s * static_cast<double>(all - done));
}

void CellJobs::tell_result(nlohmann::ordered_json result) {
  result["job"] = last_job_;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto told = std::find_if(results_.begin(), results_.end(), [&](const auto& one) {
      return result.contains("target") && one.value("target", "") == result["target"];
    });
    if (told == results_.end())
      results_.push_back(result);
    else
      *told = result;
  }
  board_.tell("result", result);
}

}  // namespace planar
