#include "planar_servo/work/run/cell_check.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/loop/health/health_check.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/work/homing/sight_homing.h"

namespace planar {
namespace {

/// Deviations of the middle of the lamps between two poses by links, reducers and lens: with an
/// error map, and without.
constexpr double kCorrectedSigma_m = 0.1e-3;
constexpr double kUncorrectedSigma_m = 2e-3;
/// One pulse of a motor, and what heat and bearings add, at the end of the arm.
constexpr double kRepeatability_m = 3e-6;
/// Twice the logarithm of odds of 10 to 1.
constexpr double kTenToOne = 4.6;
/// So far beside a place, radians, the arm meets other teeth, and dirt before the lens is the same.
constexpr double kNearby = 1.0 * kDegree;
/// The play of a gear fit for positioning, which shows where the arm arrives from either side.
constexpr double kPlay = 0.01 * kDegree;

HealthFinding without_size(HealthCause cause, const std::string& why) {
  return {cause, std::numeric_limits<double>::quiet_NaN(), "",
          std::numeric_limits<double>::infinity(), fmt::format("{}: {}", words(cause), why)};
}

std::optional<HealthFinding> wrong_separation(const LampPlaces& lamps_B, double filed_m) {
  const double seen_m = (lamps_B[1] - lamps_B[0]).norm();
  if (std::abs(seen_m / filed_m - 1.0) <= kSeparationShare) return std::nullopt;
  return HealthFinding{
      HealthCause::kSeparation, mm(seen_m), "mm", std::abs(seen_m - filed_m),
      fmt::format("{}: the lamps are seen {:.2f} mm apart, the file says {:.2f} mm",
                  words(HealthCause::kSeparation), mm(seen_m), mm(filed_m))};
}

/// Returns whether light or focus may look like this cause, which displaces the end point so far:
/// no centre is measured farther from its lamp's middle than a quarter of the diameter. Play shows
/// under constant light, and a barred way has nothing to do with light.
bool may_be_light(const HealthFinding& finding, double diameter_m) {
  constexpr double kMostOfDiameter = 0.25;
  switch (finding.what) {
    case HealthCause::kPlay1:
    case HealthCause::kPlay2:
    case HealthCause::kPlay3:
    case HealthCause::kNotVisited:
      return false;
    case HealthCause::kNotSeen:
      return true;
    default:
      return finding.cost_m < kMostOfDiameter * diameter_m;
  }
}

double repeatability_m(const CellSettings& cell) {
  if (cell.servo.approach == Approach::kOneSide) return kRepeatability_m;
  return kPlay * cell.arm.geometry.link_lengths_m.sum();
}

/// Returns whether a single stop that missed, by no more than the default limits allow, may explain
/// what was found.
bool may_be_stray(const std::vector<HealthFinding>& found) {
  return !found.empty() && found.front().cost_m > 0.0 &&
         found.front().cost_m <= GuardLimits{}.distance_m;
}

}  // namespace

CellCheck::CellCheck(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor,
                     Clock& clock, CameraWait wait)
    : cell_(cell.settings),
      vision_(cell.vision.value()),
      as_found_(cell.planner),
      robot_(robot),
      sensor_(sensor),
      clock_(clock),
      wait_(std::move(wait)),
      planner_(joint_planner(cell_)),
      ways_(cell_, [&sensor](const TipPose& tip) { return sensor.lamps_at(tip).has_value(); }),
      model_(model_of_cell(planner_, cell_.arm.home, vision_)) {}

void CellCheck::wait_for_camera(const std::string& reason) const {
  if (!wait_ || !wait_(reason)) throw WorkError(reason, Cause::kDevice);
}

std::optional<std::string> CellCheck::go_to(const Joints& theta) {
  while (const auto obstacle =
             arrive(robot_, planner_, cell_.servo, theta, [this] { return sensor_.fault(); })) {
    if (obstacle->refused) return obstacle->reason;
    wait_for_camera(obstacle->reason);
  }
  clock_.sleep_for_s(cell_.servo.settle_s);
  return std::nullopt;
}

TipMeasurement CellCheck::measure(const TipPose& expected, int frames) {
  TipMeasurement seen = sensor_.measure(expected, frames);
  while (seen.status == TipStatus::kNoPicture) {
    wait_for_camera("the camera gave no picture: " + seen.word);
    seen = sensor_.measure(expected, frames);
  }
  looks_.push_back(sensor_.last_looks());
  return seen;
}

std::optional<LampPlaces> CellCheck::look() {
  const TipPose expected = planner_.arm().forward(robot_.commanded_joints());
  const TipMeasurement seen = measure(expected, 1);
  if (!seen.ok()) return sensor_.look_around();
  return LampPlaces{seen.lamps_B[0] - seen.correction, seen.lamps_B[1] - seen.correction};
}

bool CellCheck::allows(const Joints& theta) const {
  return !approach_refusal(planner_, cell_.servo, robot_.commanded_joints(), theta);
}

std::vector<HealthFinding> CellCheck::light_first(const HealthRecord& record,
                                                  std::vector<HealthFinding> found) const {
  if (!record.looks) return found;
  const auto explained =
      std::stable_partition(found.begin(), found.end(), [&](const HealthFinding& finding) {
        return !may_be_light(finding, vision_.lamps.diameters_m[0]);
      });
  double cost_m = 0.0;
  for (auto finding = explained; finding != found.end(); ++finding)
    cost_m = std::max(cost_m, finding->cost_m);
  const auto light = find_light_change(*record.looks, looks_, cost_m);
  if (!light) return found;
  found.erase(explained, found.end());
  found.insert(found.begin(), *light);
  return found;
}

std::vector<HealthFinding> CellCheck::first_moves(const std::optional<HealthRecord>& record) {
  looks_.clear();
  const std::optional<Joints> first = ways_.start(robot_.commanded_joints());
  if (!first)
    return {without_size(HealthCause::kNotVisited,
                         "it stands outside its workspace or the camera's view")};
  std::vector<HealthFinding> found = faults_in_first_moves(*first);
  if (may_be_stray(found)) found = faults_in_first_moves(*first);
  // Harmless changes are left to the revisits, which report them with their findings.
  return record && !found.empty() ? light_first(*record, std::move(found)) : found;
}

std::vector<HealthFinding> CellCheck::revisit(const HealthRecord& record) {
  looks_.clear();
  return light_first(record, changes_since(record));
}

double CellCheck::expected_s(int first_moves, const std::vector<HealthPlace>& places) const {
  const Transmission& transmission = planner_.transmission();
  const auto motors_s = [&](const Eigen::Vector3d& way) {
    return transmission.longest_move_s(Eigen::Vector3d::Zero(), way);
  };
  const bool one_side = cell_.servo.approach == Approach::kOneSide;
  const double margin = one_side ? cell_.servo.approach_margin_rad : 0.0;
  const double stop_s = motors_s(Eigen::Vector3d::Constant(margin)) + cell_.servo.settle_s +
                        cell_.servo.frames_per_measurement / cell_.camera.frame_rate_hz;
  double all_s = first_moves * (motors_s(CheckWays::first_moves()) + stop_s);
  const Joints here = robot_.commanded_joints();
  Eigen::Vector3d motors = transmission.motors_from_joints(here);
  for (const std::size_t next : ways_.visits(here, places).order) {
    const Eigen::Vector3d there = transmission.motors_from_joints(places[next].theta);
    all_s += motors_s(there - motors) + stop_s;
    motors = there;
  }
  return places.empty() ? all_s : all_s + stop_s;  // the last one from the other side as well
}

std::vector<HealthFinding> CellCheck::faults_in_first_moves(Joints theta) {
  std::vector<ArmSight> sights;
  for (int motor = -1; motor < 3; ++motor) {
    const Joints before = theta;
    if (motor >= 0) theta = ways_.with_motor_turned(theta, motor);
    if (motor >= 0 && theta == before)
      spdlog::warn(
          fmt::format("motor {} cannot be turned here by a quarter of a first move: a wrong "
                      "direction, gear or limit of it would not be seen",
                      motor + 1));
    if (const auto reason = go_to(theta)) return {without_size(HealthCause::kNotVisited, *reason)};
    const auto lamps_B = look();
    if (!lamps_B)
      return {without_size(HealthCause::kNotSeen, "the whole frame does not show two of them")};
    if (auto found = wrong_separation(*lamps_B, vision_.lamps.separation_m)) return {*found};
    sights.push_back({planner_.transmission().motors_from_joints(robot_.commanded_joints()),
                      *lamps_B, vision_.error_map ? kCorrectedSigma_m : kUncorrectedSigma_m});
  }
  return find_arm_faults(model_, sights);
}

std::variant<Revisit, HealthFinding> CellCheck::visit(const HealthPlace& place) {
  if (const auto reason = go_to(place.theta))
    return without_size(HealthCause::kNotVisited, place.id + ": " + *reason);
  const TipMeasurement seen =
      measure(tip_from_places(place.lamps_B, vision_.tool), cell_.servo.frames_per_measurement);
  if (!seen.ok()) return without_size(HealthCause::kNotSeen, place.id + ": " + seen.word);
  return Revisit{
      planner_.transmission().motors_from_joints(place.theta),
      place.lamps_B,
      seen.lamps_B,
      std::hypot(std::sqrt(2.0) * std::hypot(place.sigma_m, seen.noise_m), repeatability_m(cell_)),
      as_found_.scatter_m(),
      as_found_.wander_m()};
}

std::vector<HealthFinding> CellCheck::changes_since(const HealthRecord& record) {
  const VisitPlan plan = ways_.visits(robot_.commanded_joints(), record.places);
  if (!plan.barred.empty()) {
    const std::string barred = barred_text(plan.barred, record.places.size());
    if (plan.order.empty()) return {without_size(HealthCause::kNotVisited, barred)};
    spdlog::warn(barred);
  }
  std::vector<Revisit> revisits;
  std::vector<HealthPlace> visited_places;
  for (const std::size_t next : plan.order) {
    const auto visited = visit(record.places[next]);
    if (const auto* finding = std::get_if<HealthFinding>(&visited)) return {*finding};
    revisits.push_back(std::get<Revisit>(visited));
    visited_places.push_back(record.places[next]);
  }
  if (revisits.empty()) return {};
  constexpr int kRounds = 2;    // two stops in a row stray once in some thousand times
  std::vector<double> moved_m;  // from stop to stop at the same places
  for (int round = 0; round < kRounds && has_changed(model_, revisits); ++round) {
    const std::vector<Revisit> before = revisits;
    if (auto finding = visit_again(visited_places, revisits)) return {*finding};
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Eigen::Vector2d moved = 0.5 * (revisits[i].now_B[0] + revisits[i].now_B[1] -
                                           before[i].now_B[0] - before[i].now_B[1]);
      if (!moved.isZero(0.0)) moved_m.push_back(moved.norm());  // else it was not visited again
    }
    // Where no file says the arm's scatter, it is taken as twice what the stops show per axis,
    // since so few may show half of it. That is the rms of their distances.
    if (!as_found_.found() && !moved_m.empty())
      for (Revisit& revisit : revisits) revisit.scatter_m = rms(moved_m);
    if (auto found = judge_odd_place(visited_places, revisits); !found.empty()) return found;
  }
  // Play that has grown displaces the arm on either side, as a lost zero would.
  std::vector<HealthFinding> play = play_now(visited_places, revisits);
  return play.empty() ? find_changes(model_, revisits) : play;
}

std::optional<HealthFinding> CellCheck::visit_again(const std::vector<HealthPlace>& places,
                                                    std::vector<Revisit>& revisits) {
  std::vector<std::size_t> again = farthest_off_first(revisits);
  again.resize(std::min<std::size_t>(2, again.size()));
  // If the arm stands at one of them, it visits the other first.
  const auto way = [&](std::size_t index) {
    return (places[index].theta - robot_.commanded_joints()).norm();
  };
  if (way(again.front()) < way(again.back())) std::swap(again.front(), again.back());
  for (const std::size_t index : again) {
    if (!allows(places[index].theta)) continue;
    const auto visited = visit(places[index]);
    if (const auto* finding = std::get_if<HealthFinding>(&visited)) return *finding;
    revisits[index] = std::get<Revisit>(visited);
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> CellCheck::seen_beside(const Joints& theta) {
  if (!allows(theta) || go_to(theta)) return std::nullopt;
  const TipPose expected = as_found_.reached(robot_.commanded_joints());
  const TipMeasurement seen = measure(expected, cell_.servo.frames_per_measurement);
  if (!seen.ok()) return std::nullopt;
  return seen.tip.p - expected.p;
}

std::vector<HealthFinding> CellCheck::judge_odd_place(const std::vector<HealthPlace>& places,
                                                      std::vector<Revisit>& revisits) {
  const auto odd = stray_place(model_, revisits);
  if (!odd) return {};
  const Revisit at = revisits[*odd];
  const HealthPlace& place = places[*odd];
  const Eigen::Vector2d moved =
      tip_from_places(at.now_B, vision_.tool).p - tip_from_places(at.then_B, vision_.tool).p;
  const double odds = odds_of_stray(place, places, moved);
  const std::string what = fmt::format(
      "only place '{}' is not where it was, by {:.3f} mm: ", place.id, mm(moved.norm()));
  if (odds < -kTenToOne) {
    std::vector<HealthFinding> found = find_changes(model_, revisits);
    if (found.front().what == HealthCause::kSeveral) found.clear();
    found.push_back({HealthCause::kView, mm(moved.norm()), "mm", moved.norm(),
                     what + words(HealthCause::kView)});
    return found;
  }
  revisits.erase(revisits.begin() + static_cast<std::ptrdiff_t>(*odd));
  spdlog::warn(what + "the arm strayed there when it was recorded" +
               (odds > kTenToOne ? "" : ", or the view has changed there") +
               "; the place is left out of the check");
  return {};
}

/// Looks at the place and at two beside it, and at the others. The arm as it was found and the
/// compensated view agree where both are as at the calibration: an arm that strayed when the place
/// was recorded makes them agree there now, a view that has changed there no longer.
double CellCheck::odds_of_stray(const HealthPlace& place, const std::vector<HealthPlace>& places,
                                const Eigen::Vector2d& moved) {
  if (!as_found_.found()) return 0.0;
  std::vector<Eigen::Vector2d> others;
  for (const HealthPlace& other : places)
    if (other.id != place.id)
      if (const auto beside = seen_beside(other.theta)) others.push_back(*beside);
  if (others.size() < 2) return 0.0;
  double squares = 0.0;
  for (const Eigen::Vector2d& beside : others) squares += beside.squaredNorm();
  const double variance = squares / (2.0 * static_cast<double>(others.size()));
  double odds = 0.0;
  for (const double nearby : {0.0, kNearby, -kNearby})
    if (const auto now = seen_beside(place.theta + Joints(nearby, nearby, nearby)))
      odds += ((*now - moved).squaredNorm() - now->squaredNorm()) / variance;
  return odds;
}

std::vector<HealthFinding> CellCheck::play_now(const std::vector<HealthPlace>& places,
                                               const std::vector<Revisit>& revisits) {
  std::vector<HealthFinding> here = play_here(revisits);
  if (here.empty() || places.size() < 2) return here;
  const auto way = [&](const HealthPlace& place) {
    return allows(place.theta) ? (place.theta - robot_.commanded_joints()).norm() : -1.0;
  };
  const auto elsewhere =
      std::max_element(places.begin(), places.end(),
                       [&](const HealthPlace& a, const HealthPlace& b) { return way(a) < way(b); });
  if (way(*elsewhere) < 0.0) return {};
  if (const auto visited = visit(*elsewhere); std::holds_alternative<HealthFinding>(visited))
    return {std::get<HealthFinding>(visited)};
  return play_here(revisits);
}

std::vector<HealthFinding> CellCheck::play_here(const std::vector<Revisit>& revisits) {
  const Transmission& transmission = planner_.transmission();
  const Joints here = robot_.commanded_joints();
  const Eigen::Vector3d present = transmission.motors_from_joints(here);
  const Revisit& from_below =
      *std::min_element(revisits.begin(), revisits.end(), [&](const Revisit& a, const Revisit& b) {
        return (a.motors - present).norm() < (b.motors - present).norm();
      });
  const Joints theta = transmission.joints_from_motors(from_below.motors);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(cell_.servo.approach_margin_rad);
  const Joints above = transmission.joints_from_motors(from_below.motors + margin);
  if (planner_.refusal(above) || planner_.way_refusal(here, above) ||
      planner_.way_refusal(above, theta))
    return {};
  for (const Joints& stop : {above, theta})
    while (const auto objection = robot_.move_to(stop, [this] { return sensor_.fault(); }))
      wait_for_camera(*objection);
  clock_.sleep_for_s(cell_.servo.settle_s);
  const TipMeasurement seen =
      measure(planner_.arm().forward(theta), cell_.servo.frames_per_measurement);
  if (!seen.ok()) return {without_size(HealthCause::kNotSeen, seen.word)};
  return find_play(model_, {from_below.motors, from_below.now_B, seen.lamps_B, from_below.sigma_m},
                   0.5 * cell_.servo.approach_margin_rad);
}

GuardLimits with_health(GuardLimits limits, const HealthRecord& record) {
  constexpr double kMargin = 1.5;  // over what the calibration saw
  limits.distance_m = kMargin * record.distance_m;
  limits.turn = kMargin * record.turn;
  limits.separation_m = record.separation_m;
  limits.separation_tolerance_m = kMargin * record.separation_spread_m;
  return limits;
}

std::vector<HealthFinding> check_cell(CellCheck& check, const std::optional<HealthRecord>& record) {
  const std::string visits =
      record ? fmt::format(", then the arm visits {} places of the calibration once more",
                           record->places.size())
             : "";
  constexpr int kStops = 4;  // the start and one for each motor
  spdlog::info(
      "checking the cell: each motor turns a little" + visits + "; " +
      about_time(check.expected_s(kStops, record ? record->places : std::vector<HealthPlace>())));
  std::vector<HealthFinding> found = check.first_moves(record);
  if (!found.empty()) return found;
  return record ? check.revisit(*record) : std::vector<HealthFinding>();
}

std::vector<HealthFinding> check_again(CellCheck& check, const HealthRecord& record) {
  spdlog::info(
      fmt::format("checking the cell again: the arm visits {} places of the calibration; {}",
                  record.places.size(), about_time(check.expected_s(0, record.places))));
  return check.revisit(record);
}

std::vector<HealthFinding> check_devices(const CalibratedCell& cell, CellDevices& devices,
                                         const MayHome& may_home,
                                         const std::function<bool()>& stop) {
  require_checkable(cell);
  const CellSettings& settings = cell.settings;
  PlanarRobot robot(PlanarArm(settings.arm.geometry), Transmission(settings.transmission),
                    devices.drives(), devices.clock());
  robot.stop_when(stop);
  robot.energize();
  LampTipSensor sensor(*cell.vision, settings.lamps.method, devices.camera(),
                       settings.camera.follow_region_px);
  home_where_needed(robot, may_home, "", [&] { home_by_sight(cell, robot, sensor, may_home); });
  CellCheck check(cell, robot, sensor, devices.clock(), [&](const std::string& reason) {
    return wait_for_camera(devices.camera(), robot, devices.clock(), "the check", reason,
                           devices.clock().now_s() + kCameraPatience_s);
  });
  return check_cell(check, cell.health);
}

std::string findings_text(const std::vector<HealthFinding>& findings) {
  std::string text;
  for (const HealthFinding& finding : findings)
    text += fmt::format("{}; what still holds: {}; what to do: {}\n", finding.fault,
                        usable(finding.what), finding.remedy);
  return text;
}

nlohmann::ordered_json findings_json(const std::vector<HealthFinding>& findings) {
  auto list = nlohmann::ordered_json::array();
  for (const HealthFinding& finding : findings) {
    nlohmann::ordered_json size, unit;  // null for what has none
    if (std::isfinite(finding.size)) {
      size = finding.size;
      unit = finding.unit;
    }
    list.push_back({{"cause", words(finding.what)},
                    {"size", size},
                    {"unit", unit},
                    {"usable", usable(finding.what)},
                    {"redo", finding.remedy}});
  }
  return {{"healthy", findings.empty()}, {"findings", list}};
}

}  // namespace planar
