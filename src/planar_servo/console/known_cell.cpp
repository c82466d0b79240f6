#include "planar_servo/console/known_cell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "planar_servo/base/core/units.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// So many arrows of the error map stand on the longer side of its region.
constexpr int kArrowsAcross = 16;

bool is_there(const std::optional<fs::path>& file) {
  return file && fs::exists(*file);
}

const ValidRegion& region_of(const VisionErrorMap& map) {
  if (const auto* field = std::get_if<LampField>(&map)) return field->region;
  return valid_region(std::get<ErrorMap>(map));
}

ordered_json disc_json(const KeepOut& disc) {
  return {{"x_mm", json_number(mm(disc.p_B.x()))},
          {"y_mm", json_number(mm(disc.p_B.y()))},
          {"radius_mm", json_number(mm(disc.radius_m))}};
}

ordered_json barrier_json(const Barrier& barrier) {
  std::vector<Eigen::Vector2d> outline = barrier.corners_B;
  if (outline.size() == 1) {
    constexpr int kCorners = 36;
    for (int i = 1; i <= kCorners; ++i)
      outline.emplace_back(barrier.corners_B[0] +
                           barrier.radius_m * rotation2d(2.0 * kPi * i / kCorners).col(0));
    outline.erase(outline.begin());
  }
  return {{"name", barrier.name}, {"outline_mm", json_list(outline, json_mm)}};
}

/// Returns the end point's way from rest to rest, to draw it.
ordered_json way_json(const JointPlanner& planner, Joints from, const ApproachWay& way) {
  std::vector<Eigen::Vector2d> places;
  for (const Joints& stop : way.stops) {
    const auto drawn = planner.drawn_way(from, stop);
    places.insert(places.end(), drawn.begin(), drawn.end());
    from = stop;
  }
  return json_list(places, json_mm);
}

ordered_json arrow_json(const Eigen::Vector2d& p, const ErrorPrediction& error) {
  return {{"x_mm", json_number(mm(p.x()))},
          {"y_mm", json_number(mm(p.y()))},
          {"dx_mm", json_number(mm(error.error.x()))},
          {"dy_mm", json_number(mm(error.error.y()))},
          {"sigma_mm", json_number(mm(error.sigma))}};
}

ArmStand stand_at(const JointPlanner& planner, const std::array<DriveStatus, 3>& drives) {
  const Pulses pulses(drives[0].position_pulses, drives[1].position_pulses,
                      drives[2].position_pulses);
  const Joints theta = planner.transmission().joints_from_pulses(pulses);
  const PlanarArm& arm = planner.arm();
  const Eigen::Vector2d elbow(std::cos(theta[0]), arm.sense() * std::sin(theta[0]));
  return {theta, arm.geometry().link_lengths_m[0] * elbow, arm.forward(theta)};
}

/// Says what is to be done with drives before the arm can move; empty when it can.
std::string to_do(const CellSettings& cell, const std::array<DriveStatus, 3>& drives,
                  bool enabled) {
  if (!enabled) return "enable the drives";
  std::vector<std::string> ways;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (drives[i].position_certain) continue;
    const MotorDrive& motor = cell.transmission.drives[i];
    if (motor.home == HomeReference::kSight)
      return "home the arm: the camera finds where it stands, for which joints turn a little";
    ways.push_back(motor.home == HomeReference::kTaught
                       ? fmt::format("turn joint {0} to its mark at {1:.3f} deg by hand, then mark "
                                     "{0}",
                                     i + 1, motor.home_rad / kDegree)
                       : fmt::format("home joint {}, which moves the arm", i + 1));
  }
  return fmt::format("{}", fmt::join(ways, "; "));
}

}  // namespace

KnownCell::KnownCell(const fs::path& cell_file)
    : cell_(read_calibrated_cell(read_cell(cell_file))),
      folder_(fs::weakly_canonical(cell_file).parent_path()) {}

std::vector<Refusal> KnownCell::doubts() const {
  std::vector<Refusal> doubts;
  try {
    const CalibratedCell now = read_calibrated_cell(settings(), fs::exists(settings().error_map));
    for (const StaleFile& stale : now.stale)
      doubts.push_back(stale.at(stale.path.filename().string()));
    if (auto doubt = foresee_check(now).doubt) doubts.push_back(std::move(*doubt));
  } catch (const InputError& e) {
    doubts = e.refusals();
  }
  if (cell_.vision && cell_.vision->map_objection)
    doubts.push_back(cell_.vision->map_objection->at(settings().error_map.filename().string()));
  return doubts;
}

ArmState KnownCell::arm_at(const std::array<DriveStatus, 3>& drives, bool enabled) const {
  ArmState state;
  state.enabled = enabled && std::all_of(drives.begin(), drives.end(),
                                         [](const auto& drive) { return drive.energized; });
  if (std::all_of(drives.begin(), drives.end(),
                  [](const auto& drive) { return drive.position_certain; }))
    state.stand = stand_at(cell_.planner, drives);
  state.to_do = to_do(settings(), drives, state.enabled);
  return state;
}

ordered_json KnownCell::json() const {
  std::call_once(map_made_, [this] { map_ = map_json(); });
  const CellSettings& cell = settings();
  const auto limits = json_list(cell.transmission.limits_rad, [](const Eigen::Vector2d& limit) {
    return json_numbers(limit / kDegree);
  });
  const Eigen::Vector2d lengths_m = cell.arm.geometry.link_lengths_m;
  return {{"name", folder_.filename().string()},
          {"virtual", cell.truth.has_value()},
          {"camera", {{"width_px", cell.camera.width_px}, {"height_px", cell.camera.height_px}}},
          {"arm", {{"link_lengths_mm", json_mm(lengths_m)}, {"joint_limits_deg", limits}}},
          {"workspace",
           {{"radius_min_mm", json_number(mm(cell.workspace.radius_min_m))},
            {"radius_max_mm", json_number(mm(cell.workspace.radius_max_m))},
            {"keep_out", json_list(cell.workspace.keep_out, disc_json)},
            {"obstacles", json_list(cell.workspace.barriers, barrier_json)}}},
          {"has",
           {{"camera_model", fs::exists(cell.camera_model)},
            {"workplane", fs::exists(cell.workplane)},
            {"tool", fs::exists(cell.tool)},
            {"error_map", fs::exists(cell.error_map)},
            {"health", is_there(cell.health)},
            {"arm_found", is_there(cell.arm_found)}}},
          {"map", map_},
          {"teach", teach().filename().string()}};
}

ordered_json KnownCell::map_json() const {
  if (!uses_error_map(cell_)) return nullptr;
  const ValidRegion& region = region_of(*cell_.vision->error_map);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : region.hull) box.extend(corner);
  auto arrows = ordered_json::array();
  const double step = box.isEmpty() ? 0.0 : box.sizes().maxCoeff() / kArrowsAcross;
  for (double x = box.min().x() + 0.5 * step; step > 0.0 && x < box.max().x(); x += step)
    for (double y = box.min().y() + 0.5 * step; y < box.max().y(); y += step) {
      const ErrorPrediction error =
          predict_error_at(*cell_.vision, {{x, y}, settings().tool_orientation});
      if (error.inside) arrows.push_back(arrow_json({x, y}, error));
    }
  return {{"region_mm", json_list(region.hull, json_mm)}, {"arrows", arrows}};
}

ordered_json KnownCell::place_json(const TipPose& pose, const Joints& from) const {
  const JointPlan plan = cell_.planner.plan(pose, from);
  const ApproachWay way = plan.refusal
                              ? ApproachWay{{}, plan.refusal}
                              : approach_way(cell_.planner, settings().servo, from, plan.theta);
  const std::optional<std::string>& why = way.refusal;
  ordered_json answer{{"reachable", !why},
                      {"why", why ? ordered_json(*why) : ordered_json(nullptr)},
                      {"sigma_mm", nullptr},
                      {"error_mm", nullptr},
                      {"in_region", false},
                      {"barred", way.barred ? ordered_json(*way.barred) : ordered_json(nullptr)},
                      {"way_mm", way_json(cell_.planner, from, way)}};
  if (!uses_error_map(cell_)) return answer;
  const ErrorPrediction error = predict_error_at(*cell_.vision, pose);
  answer["sigma_mm"] = json_number(mm(error.sigma));
  answer["error_mm"] = json_mm(error.error);
  answer["in_region"] = error.inside;
  return answer;
}

}  // namespace planar
