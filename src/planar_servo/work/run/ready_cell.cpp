#include "planar_servo/work/run/ready_cell.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <limits>
#include <stdexcept>
#include <variant>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/work/homing/sight_homing.h"
#include "planar_servo/work/run/cell_check.h"

namespace planar {
namespace {

constexpr double kKeepEvery_s = 600.0;
/// Places across the workspace whose postures are tried as centres of Gaussians, closer together
/// than these are wide.
constexpr double kPlacesAcross = 24.0;

std::vector<Joints> reachable_postures(const CellSettings& cell, const JointPlanner& planner) {
  std::vector<Joints> postures;
  const double reach_m = cell.workspace.radius_max_m;
  const double step_m = 2.0 * reach_m / kPlacesAcross;
  for (double x = -reach_m; x <= reach_m; x += step_m)
    for (double y = -reach_m; y <= reach_m; y += step_m) {
      const JointPlan plan = planner.plan({{x, y}, cell.tool_orientation}, cell.arm.home);
      if (!plan.refusal) postures.push_back(plan.theta);
    }
  return postures;
}

/// Returns the arm in the file with the sense, coupling and gears of the found arm.
LearnedArm read_for(const FoundArm& found, const std::filesystem::path& file) {
  LearnedArm known = read_learned_arm(file);
  ArmForm& form = known.arm.form;
  form.sense = found.form.sense;
  form.joints_per_motor = found.form.joints_per_motor;
  form.gear_ratios = found.form.gear_ratios;
  return known;
}

constexpr double kDrivePatience_s = 60.0;
/// A camera that drifts by 0.1 mm an hour is noticed in this time.
constexpr double kExamineEvery_s = 600.0;
/// A shorter run costs less than another look at it.
constexpr double kWorthALook_s = 60.0;
constexpr char kChecking[] = "looking at the cell";
constexpr char kResume[] = "; add --resume to continue a run";

GuardLimits limits_of(const ServoRequest& request) {
  if (!request.policy.guards_looks) {
    GuardLimits widest;
    widest.noise_m = std::numeric_limits<double>::infinity();
    return widest;
  }
  const CalibratedCell& cell = *request.cell;
  const GuardLimits limits =
      guard_limits(*cell.vision, cell.settings.workspace, cell.settings.tool_orientation);
  return cell.health ? with_health(limits, *cell.health) : limits;
}

KeptLandings landings_of(const ServoRequest& request, const GuardLimits& limits) {
  if (!request.policy.estimates_landings) return {};
  const auto& map = request.cell->vision->error_map;
  const JointPlanner& planner = request.cell->planner;
  const LampField* field = map ? std::get_if<LampField>(&*map) : nullptr;
  const auto& arm = planner.found();
  if (field == nullptr || !arm || arm->factor.size() == 0 ||
      arm->factor.cols() != field->factor.cols())
    return {std::make_unique<UnknownLandings>(limits.distance_m), nullptr};
  const double stray_m = limits.distance_m / kDeviationsToGuard;
  if (!request.policy.learns)
    return {std::make_unique<FoundLandings>(*field, *arm, planner.transmission(), stray_m),
            nullptr};
  const CellSettings& cell = request.cell->settings;
  auto learning = std::make_unique<LearningLandings>(
      *field, *arm, remembered_arm(cell, planner, request.policy.forgets), planner.transmission(),
      stray_m);
  auto memory = cell.arm_learned ? std::make_unique<ArmMemory>(cell, *learning) : nullptr;
  return {std::move(learning), std::move(memory)};
}

const CalibratedCell& complete(const CalibratedCell& cell) {
  require_calibrated(cell);
  return cell;
}

}  // namespace

LearnedArm remembered_arm(const CellSettings& cell, const JointPlanner& planner, bool forgets) {
  const FoundArm& found = planner.found().value();
  const auto anew = [&] { return not_yet_learned(found, reachable_postures(cell, planner)); };
  if (!cell.arm_learned || !std::filesystem::exists(*cell.arm_learned)) return anew();
  if (forgets) {
    spdlog::info(cell.arm_learned->string() + ": is forgotten (--forget); learning starts anew");
    return anew();
  }
  if (const auto elsewhere = learned_elsewhere(*cell.arm_learned, learned_arm_origins(cell))) {
    spdlog::warn(*elsewhere + "; learning starts anew");
    return anew();
  }
  try {
    LearnedArm known = read_for(found, *cell.arm_learned);
    [[maybe_unused]] const ArmLearner usable(found, known);
    return known;
  } catch (const std::invalid_argument& error) {
    throw InputError(
        {error.what(), "start anew with --forget", *cell.arm_learned, Cause::kForeign});
  }
}

ArmMemory::ArmMemory(const CellSettings& cell, const LearningLandings& landings)
    : file_(cell.arm_learned.value()), origins_(learned_arm_origins(cell)), landings_(landings) {
  require_writable(file_, "arm_learned");
}

ArmMemory::~ArmMemory() {
  try {
    keep();
  } catch (const std::exception& error) {
    spdlog::error(std::string("what was learned of the arm is lost: ") + error.what());
  }
}

void ArmMemory::keep_if_due(double now_s) {
  if (!kept_s_) kept_s_ = now_s;
  if (now_s < *kept_s_ + kKeepEvery_s) return;
  kept_s_ = now_s;
  keep();
}

void ArmMemory::keep() {
  const ArmLearner& learner = landings_.learner();
  if (learner.lessons() == kept_lessons_) return;
  write_file(file_, learned_arm_text(learner.learned(), origins_, "planar-servo"));
  kept_lessons_ = learner.lessons();
}

ReadyCell::ReadyCell(const ServoRequest& request, CellDevices& devices)
    : cell_(request.cell),
      camera_(devices.camera()),
      clock_(devices.clock()),
      may_home_(request.may_home),
      check_health_(request.policy.checks_health),
      checking_(request.checking),
      found_(request.found),
      accepted_stale_(accept_stale(complete(*cell_).stale, request.accepted.stale)),
      accepted_map_(accept_map(*cell_, request.accepted.map)),
      limits_(limits_of(request)),
      sensor_(*cell_->vision, request.policy.center, devices.camera(),
              settings().camera.follow_region_px),
      robot_(PlanarArm(settings().arm.geometry), Transmission(settings().transmission),
             devices.drives(), devices.clock()),
      landings_(landings_of(request, limits_)),
      servo_(settings().servo, limits_, planner(), robot_, sensor_, devices.clock(),
             landings_.model.get()) {
  robot_.stop_when(request.stop);
  if (request.policy.checked_s_ago) examined_s_ = clock_.now_s() - *request.policy.checked_s_ago;
}

void ReadyCell::switch_on() {
  robot_.energize();
  if (examined_s_) begun_at_ = robot_.known_pulses();
  if (const auto theta = robot_.known_joints()) sensor_.aim(robot_.arm().forward(*theta));
}

std::optional<std::string> ReadyCell::examine_if_due() {
  if (!robot_.known_joints()) home();
  if (!examined_s_) {
    if (const std::string unwell = examine(); !unwell.empty())
      throw WorkError(unwell, Cause::kContradiction);
    begun_at_ = robot_.known_pulses();
    return std::string();
  }
  if (!was_examined_s_ago(kExamineEvery_s)) return std::nullopt;
  return examine();
}

void ReadyCell::home() {
  home_where_needed(robot_, may_home_, kResume,
                    [&] { home_by_sight(*cell_, robot_, sensor_, may_home_); });
}

std::optional<std::string> ReadyCell::examine_at_end() {
  if (!was_examined_s_ago(kWorthALook_s)) return std::nullopt;
  return examine();
}

/// A check that was stopped, failed or found something is made again by whoever moves next.
std::string ReadyCell::examine() {
  const double begun_s = clock_.now_s();
  std::string unwell = look_for_changes(!examined_s_);
  if (unwell.empty()) examined_s_ = begun_s;
  return unwell;
}

std::string ReadyCell::look_for_changes(bool first) {
  if (!check_health_) {
    spdlog::warn("the cell's health is not checked (--no-health)");
    return {};
  }
  const auto& health = cell_->health;
  if (!health)
    spdlog::warn(settings().file.string() +
                 ": names no health file that exists, so nobody can say what has moved since the "
                 "calibration; planar-pair-tracker --health-out makes one");
  int waits_left = kMaxCameraFailures;
  CellCheck check(*cell_, robot_, sensor_, clock_, [&](const std::string& reason) {
    return waits_left-- > 0 &&
           wait_for_camera(kChecking, reason, clock_.now_s() + kCameraPatience_s);
  });
  std::vector<Eigen::Vector2d> places;
  if (health)
    for (const HealthPlace& place : health->places)
      places.push_back(planner().arm().forward(place.theta).p);
  if (checking_) checking_(places);
  const AtEnd told([this] {
    if (checking_) checking_(std::nullopt);
  });
  int recoveries_left = kMaxDriveRecoveries;
  const std::vector<HealthFinding> found = with_drives(kChecking, recoveries_left, [&] {
    return first ? check_cell(check, health) : check_again(check, *health);
  });
  if (found_) found_(found);
  if (found.empty()) {
    if (health) spdlog::info("the cell is as it was at its calibration");
    return {};
  }
  std::string text = findings_text(found);
  text.pop_back();  // its last line end
  for (const HealthFinding& finding : found)
    if (finding.cost_m > kTolerable_m) return "the cell is not well: " + text;
  spdlog::warn(text);
  return {};
}

bool ReadyCell::stand_aside() {
  const CellSettings& cell = settings();
  const Joints here = robot_.commanded_joints();
  const Eigen::Vector2d out = robot_.arm().forward(here).p.normalized();
  const double radius_m = 0.5 * (cell.workspace.radius_min_m + cell.workspace.radius_max_m);
  for (const double turn_deg : {180.0, 120.0, -120.0, 90.0, -90.0}) {
    const Eigen::Vector2d p = radius_m * rotation2d(turn_deg * kDegree) * out;
    const JointPlan plan = planner().plan({p, cell.tool_orientation}, here);
    if (plan.refusal) continue;
    const auto obstacle =
        arrive(robot_, planner(), cell.servo, plan.theta, [this] { return sensor_.fault(); });
    if (!obstacle || !obstacle->refused) return !obstacle;
  }
  return false;
}

void ReadyCell::keep_lessons_if_due() {
  if (landings_.memory) landings_.memory->keep_if_due(clock_.now_s());
}

bool ReadyCell::was_examined_s_ago(double seconds) const {
  return check_health_ && cell_->health && examined_s_ && clock_.now_s() > *examined_s_ + seconds;
}

void ReadyCell::recover_drives(const std::string& id, const std::string& reason) {
  robot_.throw_if_stopped();
  spdlog::warn(id + ": " + reason + "; the arm stands and waits");
  try {
    robot_.recover(kDrivePatience_s);
    home();
  } catch (const DriveError& error) {
    Refusal both = error.refusal();
    both.fault = reason + "; " + both.fault;
    throw DriveError(both);
  }
  spdlog::info(id + ": the drives are ready again; resuming");
}

bool ReadyCell::wait_for_camera(const std::string& id, const std::string& reason,
                                double deadline_s) {
  return planar::wait_for_camera(camera_, robot_, clock_, id, reason, deadline_s);
}

}  // namespace planar
