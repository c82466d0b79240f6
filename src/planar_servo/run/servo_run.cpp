#include "planar_servo/run/servo_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/step_table.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/run/cell_check.h"
#include "planar_servo/run/dry_run.h"
#include "planar_servo/run/resumed_run.h"
#include "planar_servo/run/target_scorer.h"
#include "planar_servo/vision/guard_limits.h"

namespace planar {
namespace {

/// The longest wait for a camera that fails, counted from the beginning of a target.
constexpr double kCameraPatience_s = 60.0;
constexpr double kCameraPoll_s = 0.05;
constexpr double kDrivePatience_s = 60.0;
/// A camera that drifts by 0.1 mm an hour is noticed in this time.
constexpr double kExamineEvery_s = 600.0;
/// The most waits for the camera while the cell is looked at. One that fails more often is broken.
constexpr int kMaxCameraWaits = 20;
constexpr char kChecking[] = "looking at the cell";
/// The most recoveries of drives for one target. A drive that fails more often is broken.
constexpr int kMaxDriveRecoveries = 3;

GuardLimits limits_of(const CellSettings& cell, const VisionCalibration& vision,
                      const std::optional<HealthRecord>& health) {
  const GuardLimits limits = guard_limits(vision, cell.workspace, cell.tool_orientation);
  return health ? with_health(limits, *health) : limits;
}

}  // namespace

std::vector<std::string> accept_stale_files(const CellSettings& cell, bool with_error_map,
                                            bool accepted) {
  const std::vector<StaleFile> stale = stale_files(cell, with_error_map);
  if (!accepted) require_belonging(stale);
  std::vector<std::string> texts;
  texts.reserve(stale.size());
  for (const StaleFile& file : stale) texts.push_back(file.refusal.text());
  for (const std::string& text : texts) spdlog::warn("accepted: " + text);
  return texts;
}

ServoRun::ServoRun(const ServoRequest& request, CellDevices& devices, Observer observer)
    : cell_(request.cell),
      camera_(devices.camera()),
      clock_(devices.clock()),
      observer_(std::move(observer)),
      may_home_(request.may_home),
      true_tip_(devices.true_tip()),
      check_health_(request.check_health),
      keep_going_(request.keep_going),
      vision_(read_vision(cell_, request.use_error_map)),
      health_(read_cell_health(cell_)),
      sensor_(vision_, request.center, devices.camera(), cell_.camera.follow_region_px),
      accepted_stale_(accept_stale_files(cell_, request.use_error_map, request.accept_stale)),
      lock_(folder_for(request)),
      results_(results_so_far(request)),
      results_before_(results_.size()),
      steps_(request.out / "steps.csv", steps_header()),
      table_(results_file(request), results_header(csv_remarks(run_origins(request)))),
      robot_(PlanarArm(cell_.arm.geometry), Transmission(cell_.transmission), devices.drives(),
             devices.clock()),
      servo_(cell_.servo, limits_of(cell_, vision_, health_), servo_planner(cell_), robot_, sensor_,
             devices.clock()) {
  robot_.stop_when(request.stop);
  robot_.energize();
  sensor_.aim(robot_.arm().forward(robot_.commanded_joints()));
}

template <typename Attempt>
auto ServoRun::with_drives(const std::string& id, int& recoveries_left, const Attempt& attempt)
    -> decltype(attempt()) {
  while (true) {
    try {
      return attempt();
    } catch (const DriveError& error) {
      if (recoveries_left-- == 0) throw;
      recover_drives(id, error.what());
    }
  }
}

void ServoRun::examine() {
  const bool first = !examined_s_;
  examined_s_ = clock_.now_s();
  if (!check_health_) return spdlog::warn("the cell's health is not looked at (--no-health)");
  if (!health_)
    spdlog::warn(cell_.file.string() +
                 ": names no health file that exists, so nobody can say what has moved since the "
                 "calibration; planar-pair-tracker --health-out makes one");
  int waits_left = kMaxCameraWaits;
  CellCheck check(cell_, vision_, robot_, sensor_, clock_, [&](const std::string& reason) {
    return waits_left-- > 0 &&
           wait_for_camera(kChecking, reason, clock_.now_s() + kCameraPatience_s);
  });
  int recoveries_left = kMaxDriveRecoveries;
  const std::vector<HealthFinding> found = with_drives(kChecking, recoveries_left, [&] {
    return first ? check_cell(check, health_) : check.revisit(*health_);
  });
  for (const HealthFinding& finding : found)
    if (finding.cost_m > kTolerable_m)
      throw WorkError("the cell is not well: " + findings_text(found));
  if (!found.empty()) spdlog::warn(findings_text(found));
}

bool ServoRun::must_examine() const {
  if (!examined_s_) return true;
  return check_health_ && health_ && clock_.now_s() > *examined_s_ + kExamineEvery_s;
}

const TargetResult& ServoRun::move_to(const TargetRow& target) {
  if (must_examine()) examine();
  TargetScorer scorer(target, steps_, true_tip_);
  const auto attempt = [&] {
    return servo_.move_to(target_pose(target, cell_.tool_orientation), [&](const ServoStep& step) {
      scorer.observe(step);
      spdlog::debug(fmt::format("{}, step {}: {:.4f} mm from the target, content below {:.4f} mm",
                                target.id, step.iteration, step.error.norm() / kMillimetre,
                                step.stop_below_m / kMillimetre));
      if (!observer_) return;
      const TipPose& wanted = step.target;
      observer_({target.id, step, sensor_.last_frame(),
                 sensor_.lamps_at({wanted.p + step.measurement.correction, wanted.phi})});
    });
  };
  const double start_s = clock_.now_s(), deadline_s = start_s + kCameraPatience_s;
  int recoveries_left = kMaxDriveRecoveries;
  ServoResult outcome;
  do {
    outcome = with_drives(target.id, recoveries_left, attempt);
  } while (outcome.status == ServoStatus::kLostCamera &&
           wait_for_camera(target.id, outcome.reason, deadline_s));
  results_.push_back(scorer.finish(outcome, clock_.now_s() - start_s));
  if (outcome.cell_in_doubt && !keep_going_)
    ended_by_ = fmt::format("{}: {}: {}", target.id, name(outcome.status), outcome.reason);
  table_.append(result_line(results_.back()));
  return results_.back();
}

void ServoRun::recover_drives(const std::string& id, const std::string& reason) {
  spdlog::warn(fmt::format("{}: {}; the arm stands and waits", id, reason));
  robot_.recover(kDrivePatience_s);
  const std::vector<int> unhomed = robot_.unhomed();
  if (!unhomed.empty()) {
    std::string text = "drives that have lost their position:";
    for (const int joint : unhomed) text += fmt::format(" {}", joint + 1);
    if (!may_home_ || !may_home_(text))
      throw DriveError(text + "; home them with planar-jog, then go on with --resume");
    for (const int joint : unhomed) robot_.search_home(joint);
  }
  spdlog::info(fmt::format("{}: the drives are ready again; going on", id));
}

bool ServoRun::wait_for_camera(const std::string& id, const std::string& reason,
                               double deadline_s) {
  const double lost_s = clock_.now_s();
  spdlog::warn(fmt::format("{}: {}; the arm stands and waits", id, reason));
  while (camera_.fault()) {
    if (clock_.now_s() > deadline_s) return false;
    robot_.throw_if_stopped();
    clock_.sleep_for_s(kCameraPoll_s);
  }
  if (clock_.now_s() > deadline_s) return false;
  spdlog::info(fmt::format("{}: the camera delivers again after {:.1f} s; going on", id,
                           clock_.now_s() - lost_s));
  return true;
}

void ServoRun::discard_if_empty() {
  if (!results_.empty()) return;
  steps_.remove();
  table_.remove();
}

bool ServoRun::has(const std::string& id) const {
  return std::any_of(results_.begin(), results_.end(),
                     [&](const TargetResult& result) { return result.id == id; });
}

std::vector<TargetResult> run_servo(
    ServoRun& run, const std::vector<TargetRow>& targets,
    const std::function<void(std::size_t done, std::size_t all)>& progress) {
  for (const TargetRow& target : targets) require_same_place(target, run.results());
  for (std::size_t i = 0; i < targets.size() && !run.ended_by(); ++i) {
    if (run.has(targets[i].id)) continue;
    run.move_to(targets[i]);
    if (progress) progress(i + 1, targets.size());
  }
  return run.results();
}

}  // namespace planar
