#include "planar_servo/files/cell_file.h"

#include <fmt/format.h>

#include <set>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"

namespace planar {
namespace {

constexpr int kMaxSensorPixels = 65535;
constexpr int kLeastRegion_px = 64;
constexpr int kMaxCount = 1000;
constexpr double kMaxSettle_ms = 60000.0;

constexpr Named<Rotation> kRotations[] = {{Rotation::kCounterclockwise, "counterclockwise"},
                                          {Rotation::kClockwise, "clockwise"}};
constexpr Named<Elbow> kElbows[] = {{Elbow::kLeft, "left"}, {Elbow::kRight, "right"}};
constexpr Named<Coupling> kCouplings[] = {{Coupling::kRelative, "relative"},
                                          {Coupling::kAbsolute, "absolute"}};
constexpr Named<int> kDirections[] = {{1, "1"}, {-1, "-1"}};
constexpr Named<ServoLaw> kLaws[] = {{ServoLaw::kJacobian, "jacobian"},
                                     {ServoLaw::kInverse, "inverse"}};
constexpr Named<bool> kTruths[] = {{true, "true"}, {false, "false"}};
constexpr Named<Approach> kApproaches[] = {{Approach::kOneSide, "one_side"},
                                           {Approach::kDirect, "direct"}};

/// Reads the kind that `key` names; null when there is none of that name. The block's other keys
/// cannot be judged then.
template <typename Kind>
void read_kind(Fields& fields, const char* key, const std::vector<const Kind*>& kinds,
               const Kind*& read) {
  std::vector<std::string> names;
  names.reserve(kinds.size());
  for (const Kind* kind : kinds) names.push_back(kind->name());
  std::string name;
  read = nullptr;
  if (!fields.choice(key, name, names)) return fields.allow_rest();
  for (const Kind* kind : kinds)
    if (kind->name() == name) read = kind;
}

void read_camera(Fields& fields, CameraSettings& camera, const DeviceKinds& kinds) {
  read_kind(fields, "source", kinds.cameras, camera.kind);
  fields.whole_number("width_px", camera.width_px, 1, kMaxSensorPixels);
  fields.whole_number("height_px", camera.height_px, 1, kMaxSensorPixels);
  fields.number("frame_rate_hz", camera.frame_rate_hz, 1.0, Range::positive());
  fields.number("timeout_ms", camera.timeout_s, kMillisecond, Range::positive());
  fields.whole_number("follow_region_px", camera.follow_region_px, kLeastRegion_px,
                      kMaxSensorPixels);
  if (fields.given("pixel_pitch_um", false))
    fields.number("pixel_pitch_um", camera.pixel_pitch_m.emplace(), kMicrometre, Range::positive());
  double unused{0.0};
  if (fields.given("gain_e_per_level", false))
    fields.number("gain_e_per_level", unused, 1.0, Range::positive());
  if (camera.kind != nullptr) camera.details = camera.kind->read(fields);
}

bool check_rising(Fields& fields, const std::string& key, const std::string& name, double lower,
                  double upper) {
  return fields.check(lower < upper,
                      {fmt::format("{} is [{:g}, {:g}]", name, lower, upper),
                       "the lower limit must be below the upper one"},
                      key);
}

/// Returns whether the heights, if they are given, are heights.
bool read_heights(Fields& fields, const std::string& key, Heights& heights) {
  if (!fields.given(key, false)) return true;
  std::array<double, 2> limits{};
  if (!fields.numbers(key, limits, kMillimetre)) return false;
  heights = {limits[0], limits[1]};
  return check_rising(fields, key, key, mm(limits[0]), mm(limits[1]));
}

/// Reads what the arm takes up, which only a workspace with obstacles asks for.
void read_body(Fields& fields, ArmBody& body) {
  if (fields.given("link_width_mm", false))
    fields.numbers("link_width_mm", body.link_widths_m, kMillimetre, Range::positive());
  if (fields.given("link_height_mm", false)) {
    std::array<Eigen::Vector2d, 2> heights{};
    fields.rows("link_height_mm", heights, kMillimetre);
    for (std::size_t i = 0; i < 2; ++i) {
      check_rising(fields, "link_height_mm", fmt::format("arm.link_height_mm[{}]", i),
                   mm(heights[i].x()), mm(heights[i].y()));
      body.link_heights[i] = {heights[i].x(), heights[i].y()};
    }
  }
  if (fields.given("tool_radius_mm", false))
    fields.number("tool_radius_mm", body.tool_radius_m, kMillimetre, Range::positive());
  read_heights(fields, "tool_height_mm", body.tool_heights);
  if (fields.given("clearance_mm", false))
    fields.number("clearance_mm", body.clearance_m, kMillimetre, Range::at_least(0.0));
}

void read_arm(Fields& fields, ArmSettings& arm) {
  fields.numbers("link_lengths_mm", arm.geometry.link_lengths_m, kMillimetre, Range::positive());
  fields.choice("positive_rotation", arm.geometry.positive_rotation, kRotations);
  fields.choice("elbow", arm.elbow, kElbows);
  fields.numbers("home_deg", arm.home, kDegree);
  read_body(fields, arm.geometry.body);
}

void read_joints(Fields& fields, TransmissionSettings& transmission) {
  fields.choices("coupling", transmission.coupling, kCouplings);
  if (!fields.rows("joint_limits_deg", transmission.limits_rad, kDegree)) return;
  for (std::size_t i = 0; i < transmission.limits_rad.size(); ++i) {
    const Eigen::Vector2d& limits = transmission.limits_rad[i];
    check_rising(fields, "joint_limits_deg", fmt::format("arm.joint_limits_deg[{}]", i),
                 limits.x() / kDegree, limits.y() / kDegree);
  }
}

void read_motor(Fields& fields, MotorDrive& drive) {
  fields.number("pulses_per_motor_turn", drive.pulses_per_motor_turn, 1.0, Range::positive());
  fields.number("gear_ratio", drive.gear_ratio, 1.0, Range::positive());
  fields.choice("direction", drive.direction, kDirections);
  fields.number("max_speed_deg_s", drive.max_speed_rad_s, kDegree, Range::positive());
  fields.number("max_acceleration_deg_s2", drive.max_acceleration_rad_s2, kDegree,
                Range::positive());
}

void read_drives(Fields& fields, CellSettings& cell, const DeviceKinds& kinds) {
  std::size_t joint = 0;
  fields.maps("drives", cell.drives, [&](DriveSettings& drive) {
    read_kind(fields, "kind", kinds.drives, drive.kind);
    read_motor(fields, cell.transmission.drives[joint]);
    if (drive.kind != nullptr) drive.kind->read(fields, cell, joint);
    ++joint;
  });
}

void list_servo(Fields& fields, ServoSettings& servo) {
  fields.choice("law", servo.law, kLaws);
  fields.number("gain", servo.gain, 1.0, Range::positive(1.0));
  fields.number("tolerance_mm", servo.tolerance_m, kMillimetre, Range::positive());
  if (fields.given("orientation_tolerance_deg", true))
    fields.number("orientation_tolerance_deg", servo.orientation_tolerance, kDegree,
                  Range::positive());
  fields.whole_number("max_iterations", servo.max_iterations, 0, kMaxCount);
  fields.number("max_step_mm", servo.max_step_m, kMillimetre, Range::positive());
  fields.number("settle_ms", servo.settle_s, kMillisecond, Range::from_to(0.0, kMaxSettle_ms));
  fields.whole_number("frames_per_measurement", servo.frames_per_measurement, 1, kMaxCount);
  fields.choice("approach", servo.approach, kApproaches);
  if (fields.given("learn", true)) fields.choice("learn", servo.learns, kTruths);
}

/// Reads a disc or a polygon. Returns whether it has an area.
bool read_outline(Fields& fields, Barrier& barrier) {
  std::vector<Eigen::Vector2d>& corners = barrier.corners_B;
  if (fields.given("polygon_mm", false))
    return fields.rows("polygon_mm", corners, kMillimetre) &&
           fields.check(
               is_simple_polygon(corners),
               {fmt::format("polygon_mm has {} corners that bound no area", corners.size()),
                "three or more are needed, in the order of the edge, which must not cross itself"},
               "polygon_mm");
  corners.assign(1, Eigen::Vector2d::Zero());
  const bool x = fields.number("x_mm", corners[0].x(), kMillimetre);
  const bool y = fields.number("y_mm", corners[0].y(), kMillimetre);
  return fields.number("radius_mm", barrier.radius_m, kMillimetre, Range::positive()) && x && y;
}

void read_barrier(Fields& fields, Barrier& barrier, const ArmBody& body) {
  fields.text("name", barrier.name);
  const bool has_heights = read_heights(fields, "z_mm", barrier.heights);
  if (!read_outline(fields, barrier) || !has_heights) return;
  fields.check(!body.link_heights[0].overlap(barrier.heights) ||
                   distance_m({0.0, 0.0}, {0.0, 0.0}, barrier) > 0.5 * body.link_widths_m[0],
               {fmt::format("the obstacle {} reaches over the base's axis, where link 1 turns",
                            barrier.name),
                "correct its place, or give it z_mm and the links link_height_mm", "",
                Cause::kContradiction});
}

/// Reads the workspace of an arm with this body. One that knows of obstacles but not of its own
/// width would touch them.
void read_workspace(Fields& fields, Workspace& workspace, const ArmBody& body) {
  const bool lower =
      fields.number("radius_min_mm", workspace.radius_min_m, kMillimetre, Range::at_least(0.0));
  const bool upper =
      fields.number("radius_max_mm", workspace.radius_max_m, kMillimetre, Range::positive());
  fields.check(!lower || !upper || workspace.radius_min_m < workspace.radius_max_m,
               {"workspace.radius_min_mm must be below radius_max_mm"});
  fields.maps("keep_out", workspace.keep_out, [&](KeepOut& circle) {
    fields.number("x_mm", circle.p_B.x(), kMillimetre);
    fields.number("y_mm", circle.p_B.y(), kMillimetre);
    fields.number("radius_mm", circle.radius_m, kMillimetre, Range::positive());
  });
  if (!fields.given("obstacles", false)) return;
  fields.maps("obstacles", workspace.barriers,
              [&](Barrier& barrier) { read_barrier(fields, barrier, body); });
  fields.check(workspace.barriers.empty() || body.link_widths_m.minCoeff() > 0.0,
               {"workspace.obstacles are there, but the arm's width is not known",
                "add arm.link_width_mm: [WIDTH1, WIDTH2]", "", Cause::kMissing},
               "obstacles");
}

void read_lamps(Fields& fields, LampSettings& lamps) {
  fields.numbers("diameter_mm", lamps.layout.diameters_m, kMillimetre, Range::positive());
  fields.number("separation_mm", lamps.layout.separation_m, kMillimetre, Range::positive());
  if (fields.given("method", true)) fields.choice("method", lamps.method, kCenterMethods);
}

void read_reference_lamp(Fields& fields, ReferenceLampLayout& lamp) {
  fields.text("id", lamp.id);
  fields.number("diameter_mm", lamp.diameter_m, kMillimetre, Range::positive());
  if (!fields.given("x_mm", false) && !fields.given("y_mm", false)) return;
  lamp.p_B.emplace();
  fields.number("x_mm", lamp.p_B->x(), kMillimetre);
  fields.number("y_mm", lamp.p_B->y(), kMillimetre);
}

void read_reference_lamps(Fields& fields, std::vector<ReferenceLampLayout>& lamps) {
  constexpr std::size_t kLeast = 3;
  const char* const key = "reference_lamps";
  std::set<std::string> ids;
  fields.maps(key, lamps, [&](ReferenceLampLayout& lamp) {
    read_reference_lamp(fields, lamp);
    fields.check(ids.insert(lamp.id).second, {fmt::format("{} has the id '{}' twice", key, lamp.id),
                                              "each lamp needs its own", "", Cause::kExists});
  });
  fields.check(lamps.size() >= kLeast,
               {fmt::format("{} names {}", key, lamps.size()),
                fmt::format("at least {} are needed, or a lamp that was knocked cannot be told "
                            "from a camera that moved",
                            kLeast),
                "", Cause::kInsufficient},
               key);
}

/// Reads the tracker. A file that names no source has a virtual tracker in a virtual cell and none
/// in a real one.
void read_tracker(Fields& fields, CellSettings& cell, const DeviceKinds& kinds) {
  const bool in_virtual_cell = cell.camera.kind != nullptr && cell.camera.kind->is_virtual();
  TrackerSettings& tracker = cell.tracker;
  for (const TrackerKind* kind : kinds.trackers)
    if (kind->is_virtual() == in_virtual_cell && kind->measures() == in_virtual_cell)
      tracker.kind = kind;
  if (fields.given("source", true)) read_kind(fields, "source", kinds.trackers, tracker.kind);
  const bool measures = tracker.kind == nullptr || tracker.kind->measures();
  const auto deviation = [&](const char* key, double& field) {
    if (fields.given(key, measures) || measures)
      fields.number(key, field, kMillimetre, Range::at_least(0.0));
  };
  deviation("sigma_mm", tracker.sigma_m);
  deviation("sigma_mm_per_m", tracker.sigma_m_per_m);
  if (fields.given("bias_mm", false))
    fields.number("bias_mm", tracker.bias_m.emplace(), kMillimetre, Range::at_least(0.0));
  if (tracker.kind != nullptr) tracker.details = tracker.kind->read(fields);
}

void read_datum(Fields& fields, std::vector<Monument>& datum) {
  fields.maps("datum", datum, [&](Monument& monument) {
    fields.text("id", monument.id);
    fields.number("x_mm", monument.p_B.x(), kMillimetre);
    fields.number("y_mm", monument.p_B.y(), kMillimetre);
    fields.number("z_mm", monument.p_B.z(), kMillimetre);
  });
}

/// Reads the name of a file, which stands beside the cell's.
void read_file_name(Fields& fields, const char* key, const CellSettings& cell,
                    std::filesystem::path& file) {
  std::string name;
  fields.text(key, name);
  fields.check(!finite_number(name),
               {fmt::format("{} is {}", key, name), "the name of a file is needed"}, key);
  file = cell.file.parent_path() / name;
}

void read_fields(Fields& fields, CellSettings& cell, const DeviceKinds& kinds) {
  fields.map("camera", [&] { read_camera(fields, cell.camera, kinds); });
  read_file_name(fields, "camera_model", cell, cell.camera_model);
  read_file_name(fields, "workplane", cell, cell.workplane);
  read_file_name(fields, "tool", cell, cell.tool);
  read_file_name(fields, "error_map", cell, cell.error_map);
  fields.map("arm", [&] {
    read_arm(fields, cell.arm);
    read_joints(fields, cell.transmission);
  });
  read_drives(fields, cell, kinds);
  const auto& motors = cell.transmission.drives;
  const auto by_sight = std::count_if(motors.begin(), motors.end(), [](const MotorDrive& motor) {
    return motor.home == HomeReference::kSight;
  });
  fields.check(by_sight == 0 || by_sight == 3,
               {"drives are homed by sight all three or none, because the camera sees the arm as a "
                "whole",
                "", "", Cause::kContradiction},
               "drives");
  fields.number("tool_orientation_deg", cell.tool_orientation, kDegree);
  fields.map("servo", [&] { list_servo(fields, cell.servo); });
  fields.map("workspace", [&] { read_workspace(fields, cell.workspace, cell.arm.geometry.body); });
  if (fields.given("tools", false)) {
    const std::vector<std::string> names = fields.names_in("tools");
    fields.map("tools", [&] {
      for (const std::string& name : names)
        read_file_name(fields, name.c_str(), cell, cell.tools[name]);
    });
  }
  fields.map("lamps", [&] { read_lamps(fields, cell.lamps); });
  if (fields.given("reference_lamps", true)) read_reference_lamps(fields, cell.reference_lamps);
  fields.map("tracker", [&] { read_tracker(fields, cell, kinds); });
  read_datum(fields, cell.datum);
  if (fields.given("health", true)) read_file_name(fields, "health", cell, cell.health.emplace());
  if (fields.given("arm_found", true))
    read_file_name(fields, "arm_found", cell, cell.arm_found.emplace());
  if (fields.given("arm_learned", true))
    read_file_name(fields, "arm_learned", cell, cell.arm_learned.emplace());
  fields.check(!cell.arm_learned || cell.arm_found,
               {"arm_learned needs arm_found, which it learns from", "", "", Cause::kMissing},
               "arm_learned");
  if (fields.given("virtual", true)) read_file_name(fields, "virtual", cell, cell.truth.emplace());
}

}  // namespace

std::string servo_text(const ServoSettings& servo) {
  YamlWriter yaml;
  ServoSettings written = servo;
  list_servo(yaml, written);
  std::string text = yaml.text();
  text.pop_back();
  for (std::size_t end; (end = text.find('\n')) != std::string::npos;) text.replace(end, 1, ", ");
  return text;
}

CellSettings read_cell(const std::filesystem::path& path, const DeviceKinds& kinds) {
  YamlReader reader(path, "cell");
  CellSettings cell;
  cell.file = path;
  read_fields(reader, cell, kinds);
  reader.throw_if_faulty();
  for (std::size_t i = 0; i < cell.drives.size(); ++i) cell.drives[i].kind->complete(cell, i);
  cell.transmission.moves_straight = cell.drives[0].kind->moves_straight();
  return cell;
}

}  // namespace planar
