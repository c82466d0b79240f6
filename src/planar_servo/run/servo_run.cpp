#include "planar_servo/run/servo_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/step_table.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/run/dry_run.h"
#include "planar_servo/run/target_scorer.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// The longest wait for a camera that fails, counted from the beginning of a target.
constexpr double kCameraPatience_s = 60.0;
constexpr double kCameraPoll_s = 0.05;
constexpr double kDrivePatience_s = 60.0;
/// The most recoveries of drives for one target. A drive that fails more often is broken.
constexpr int kMaxDriveRecoveries = 3;

fs::path results_file(const ServoRequest& request) {
  return request.out / "results.csv";
}

std::vector<Origin> origins_of(const ServoRequest& request) {
  std::vector<Origin> origins;
  for (const MadeFile& file : calibration_files(request.cell, request.use_error_map))
    origins.push_back(origin_of(file));
  return origins;
}

/// Throws unless a run that was begun with these files was begun with the present ones, too. One
/// that does not say what it was begun with is gone on with.
void require_same_origins(const fs::path& results, const std::vector<Origin>& present) {
  const std::vector<Origin> begun = read_origins(results);
  const auto same = [](const Origin& a, const Origin& b) {
    return a.role == b.role && a.sha256 == b.sha256;
  };
  if (begun.empty() || std::equal(begun.begin(), begun.end(), present.begin(), present.end(), same))
    return;
  const auto names = [](const std::vector<Origin>& origins) {
    std::vector<std::string> texts;
    for (const Origin& origin : origins)
      texts.push_back(fmt::format("{} {}", origin.name, origin.sha256.substr(0, 8)));
    return fmt::format("{}", fmt::join(texts, ", "));
  };
  throw InputError(
      fmt::format("{}: the run was begun with {}; now it would go on with {}; use the same files "
                  "and options, or name another folder",
                  results.string(), names(begun), names(present)));
}

/// Returns the run's folder, which is there then.
const fs::path& folder_for(const ServoRequest& request) {
  if (request.resume && !fs::exists(results_file(request)))
    throw InputError(request.out.string() +
                     ": holds no run to go on with; name the folder of one, or leave out --resume "
                     "to begin one there");
  make_folder(request.out);
  return request.out;
}

std::vector<TargetResult> results_so_far(const ServoRequest& request) {
  const fs::path results = results_file(request);
  if (!fs::exists(results)) return {};
  if (!request.resume)
    throw InputError(results.string() +
                     ": holds a run already; name another folder or add --resume");
  drop_torn_line(results);
  require_same_origins(results, origins_of(request));
  return read_results(results);
}

/// Results are written to the nanometre.
constexpr double kSamePlace_m = 1e-9;

/// Throws when a target has a result already, but of another place.
void require_same_place(const TargetRow& target, const std::vector<TargetResult>& results) {
  for (const TargetResult& result : results)
    if (result.id == target.id && (result.p_d - target.p_d).norm() > kSamePlace_m)
      throw InputError(fmt::format(
          "target '{}' is at {} now; the run to go on with has a result of it at {}; name another "
          "folder, or another id for the new place",
          target.id, place_mm(target.p_d), place_mm(result.p_d)));
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
      sensor_(read_vision(cell_, request.use_error_map), request.center, devices.camera(),
              cell_.camera.follow_region_px),
      accepted_stale_(accept_stale_files(cell_, request.use_error_map, request.accept_stale)),
      lock_(folder_for(request)),
      results_(results_so_far(request)),
      results_before_(results_.size()),
      steps_(request.out / "steps.csv", steps_header()),
      table_(results_file(request), results_header(csv_remarks(origins_of(request)))),
      robot_(PlanarArm(cell_.arm.geometry), Transmission(cell_.transmission), devices.drives(),
             devices.clock()),
      servo_(cell_.servo, joint_planner(cell_), robot_, sensor_, devices.clock()) {
  robot_.stop_when(request.stop);
  robot_.energize();
  sensor_.aim(robot_.arm().forward(robot_.commanded_joints()));
}

const TargetResult& ServoRun::move_to(const TargetRow& target) {
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
  table_.append(result_line(results_.back()));
  return results_.back();
}

ServoResult ServoRun::with_drives(const std::string& id, int& recoveries_left,
                                  const std::function<ServoResult()>& attempt) {
  while (true) {
    try {
      return attempt();
    } catch (const DriveError& error) {
      if (recoveries_left-- == 0) throw;
      recover_drives(id, error.what());
    }
  }
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
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (run.has(targets[i].id)) continue;
    run.move_to(targets[i]);
    if (progress) progress(i + 1, targets.size());
  }
  return run.results();
}

}  // namespace planar
