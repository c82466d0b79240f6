#include "planar_servo/files/cell_file.h"

#include <fmt/format.h>

#include <optional>

#include "planar_servo/core/error.h"
#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/yaml_reader.h"

namespace planar {
namespace {

constexpr int kMaxSensorPixels = 65535;
constexpr int kLeastRegion_px = 64;
constexpr int kMaxCount = 1000;

constexpr Named<Rotation> kRotations[] = {{Rotation::kCounterclockwise, "counterclockwise"},
                                          {Rotation::kClockwise, "clockwise"}};
constexpr Named<Elbow> kElbows[] = {{Elbow::kLeft, "left"}, {Elbow::kRight, "right"}};
constexpr Named<Coupling> kCouplings[] = {{Coupling::kRelative, "relative"},
                                          {Coupling::kAbsolute, "absolute"}};
constexpr Named<int> kDirections[] = {{1, "1"}, {-1, "-1"}};
constexpr Named<ServoLaw> kLaws[] = {{ServoLaw::kJacobian, "jacobian"},
                                     {ServoLaw::kInverse, "inverse"}};
constexpr Named<Approach> kApproaches[] = {{Approach::kOneSide, "one_side"},
                                           {Approach::kDirect, "direct"}};

/// Returns the kind that `key` asks for. When there is none of that name it adds a fault and
/// returns null. The block's other keys cannot be judged then and are not called unknown.
template <typename Kind>
const Kind* kind_at(const YamlNode& node, const char* key, const std::vector<const Kind*>& kinds) {
  std::vector<std::string> names;
  names.reserve(kinds.size());
  for (const Kind* kind : kinds) names.push_back(kind->name());
  const std::optional<std::string> name = node.child(key).as_choice(names);
  for (const Kind* kind : kinds)
    if (name && kind->name() == *name) return kind;
  node.allow_all();
  return nullptr;
}

CameraSettings read_camera(const YamlNode& node, const DeviceKinds& kinds) {
  CameraSettings camera;
  camera.kind = kind_at(node, "source", kinds.cameras);
  camera.width_px = node.whole_number_in("width_px", 1, kMaxSensorPixels);
  camera.height_px = node.whole_number_in("height_px", 1, kMaxSensorPixels);
  camera.frame_rate_hz = node.positive("frame_rate_hz");
  camera.timeout_s = node.positive("timeout_ms") * kMillisecond;
  camera.follow_region_px =
      node.whole_number_in("follow_region_px", kLeastRegion_px, kMaxSensorPixels);
  for (const char* data_sheet : {"pixel_pitch_um", "gain_e_per_level"})
    if (node.has(data_sheet)) node.positive(data_sheet);
  if (camera.kind != nullptr) camera.details = camera.kind->read(node);
  return camera;
}

ArmSettings read_arm(const YamlNode& node) {
  ArmSettings arm;
  const auto lengths = node.numbers("link_lengths_mm", 2);
  for (int i = 0; i < 2; ++i) {
    arm.geometry.link_lengths_m[i] = lengths[i] * kMillimetre;
    if (!(lengths[i] > 0.0) && node.has("link_lengths_mm"))
      node.add_fault(
          fmt::format("arm.link_lengths_mm has {}; lengths must be positive", lengths[i]));
  }
  arm.geometry.positive_rotation = node.choice("positive_rotation", kRotations);
  arm.elbow = node.choice("elbow", kElbows);
  const auto home = node.numbers("home_deg", 3);
  arm.home = Joints(home[0], home[1], home[2]) * kDegree;
  return arm;
}

MotorDrive read_motor(const YamlNode& node) {
  MotorDrive drive;
  drive.pulses_per_motor_turn = node.positive("pulses_per_motor_turn");
  drive.gear_ratio = node.positive("gear_ratio");
  drive.direction = node.choice("direction", kDirections);
  drive.max_speed_rad_s = node.positive("max_speed_deg_s") * kDegree;
  drive.max_acceleration_rad_s2 = node.positive("max_acceleration_deg_s2") * kDegree;
  return drive;
}

Eigen::Vector2d read_limits(const YamlNode& node, std::size_t motor) {
  const auto range = node.as_numbers(2);
  if (!range) return Eigen::Vector2d::Zero();
  const double lower = (*range)[0], upper = (*range)[1];
  if (!(lower < upper))
    node.add_fault(
        fmt::format("arm.joint_limits_deg[{}] is [{}, {}]; the lower limit must be "
                    "below the upper one",
                    motor, lower, upper));
  return Eigen::Vector2d(lower, upper) * kDegree;
}

Coupling coupling_of(const YamlNode& node) {
  const std::optional<std::string> name = node.as_choice(names_of(kCouplings));
  return name ? *value_named(kCouplings, *name) : Coupling::kRelative;
}

void read_transmission(const YamlNode& root, const DeviceKinds& kinds, CellSettings& cell) {
  const YamlNode arm = root.child("arm");
  const auto couplings = arm.list("coupling", 2);
  for (std::size_t i = 0; i < couplings.size(); ++i)
    cell.transmission.coupling[i] = coupling_of(couplings[i]);
  const auto limits = arm.list("joint_limits_deg", 3);
  for (std::size_t i = 0; i < limits.size(); ++i)
    cell.transmission.limits_rad[i] = read_limits(limits[i], i);
  const auto drives = root.list("drives", 3);
  for (std::size_t i = 0; i < drives.size(); ++i) {
    cell.drives[i].kind = kind_at(drives[i], "kind", kinds.drives);
    cell.transmission.drives[i] = read_motor(drives[i]);
    if (cell.drives[i].kind != nullptr) cell.drives[i].kind->read(drives[i], cell, i);
  }
}

ServoSettings read_servo(const YamlNode& node) {
  ServoSettings servo;
  servo.law = node.choice("law", kLaws);
  servo.gain = node.positive("gain", 1.0);
  servo.tolerance_m = node.positive("tolerance_mm") * kMillimetre;
  servo.max_iterations = node.whole_number_in("max_iterations", 0, kMaxCount);
  servo.max_step_m = node.positive("max_step_mm") * kMillimetre;
  servo.settle_s = node.number_in("settle_ms", 0.0) * kMillisecond;
  servo.frames_per_measurement = node.whole_number_in("frames_per_measurement", 1, kMaxCount);
  servo.approach = node.choice("approach", kApproaches);
  return servo;
}

Workspace read_workspace(const YamlNode& node) {
  Workspace workspace;
  workspace.radius_min_m = node.number_in("radius_min_mm", 0.0) * kMillimetre;
  workspace.radius_max_m = node.positive("radius_max_mm") * kMillimetre;
  if (workspace.radius_min_m >= workspace.radius_max_m)
    node.add_fault("workspace.radius_min_mm must be below radius_max_mm");
  for (const YamlNode& item : node.list("keep_out"))
    workspace.keep_out.push_back(
        {Eigen::Vector2d(item.number("x_mm"), item.number("y_mm")) * kMillimetre,
         item.positive("radius_mm") * kMillimetre});
  return workspace;
}

LampSettings read_lamps(const YamlNode& node) {
  LampSettings lamps;
  const auto diameters = node.numbers("diameter_mm", 2);
  lamps.layout.diameters_m = {diameters[0] * kMillimetre, diameters[1] * kMillimetre};
  lamps.layout.separation_m = node.positive("separation_mm") * kMillimetre;
  if (node.has("method")) lamps.method = node.choice("method", kCenterMethods);
  return lamps;
}

/// Reads the tracker. A file that names no source has a virtual tracker in a virtual cell and none
/// in a real one.
TrackerSettings read_tracker(const YamlNode& node, const CellSettings& cell,
                             const DeviceKinds& kinds) {
  TrackerSettings tracker;
  const bool in_virtual_cell = cell.camera.kind != nullptr && cell.camera.kind->is_virtual();
  for (const TrackerKind* kind : kinds.trackers)
    if (kind->is_virtual() == in_virtual_cell) tracker.kind = kind;
  if (node.has("source")) tracker.kind = kind_at(node, "source", kinds.trackers);
  tracker.sigma_m = node.number_in("sigma_mm", 0.0) * kMillimetre;
  tracker.sigma_m_per_m = node.number_in("sigma_mm_per_m", 0.0) * kMillimetre;
  return tracker;
}

std::vector<Monument> read_datum(const YamlNode& root) {
  std::vector<Monument> datum;
  for (const YamlNode& item : root.list("datum"))
    datum.push_back({item.text("id"), Eigen::Vector3d(item.number("x_mm"), item.number("y_mm"),
                                                      item.number("z_mm")) *
                                          kMillimetre});
  return datum;
}

}  // namespace

CellSettings read_cell(const std::filesystem::path& path, const DeviceKinds& kinds) {
  const YamlDocument document = YamlDocument::read(path, "cell");
  const YamlNode root = document.root();
  CellSettings cell;
  cell.file = path;
  const auto beside = [&](const char* key) { return path.parent_path() / root.text(key); };
  cell.camera = read_camera(root.child("camera"), kinds);
  cell.camera_model = beside("camera_model");
  cell.workplane = beside("workplane");
  cell.tool = beside("tool");
  cell.error_map = beside("error_map");
  cell.arm = read_arm(root.child("arm"));
  read_transmission(root, kinds, cell);
  cell.tool_orientation = root.number("tool_orientation_deg") * kDegree;
  cell.servo = read_servo(root.child("servo"));
  cell.workspace = read_workspace(root.child("workspace"));
  cell.lamps = read_lamps(root.child("lamps"));
  cell.tracker = read_tracker(root.child("tracker"), cell, kinds);
  cell.datum = read_datum(root);
  if (root.has("virtual")) cell.truth = beside("virtual");
  document.throw_if_faulty();
  for (std::size_t i = 0; i < cell.drives.size(); ++i) cell.drives[i].kind->complete(cell, i);
  return cell;
}

const std::filesystem::path& require_made(const std::filesystem::path& path,
                                          const std::string& program) {
  if (!std::filesystem::exists(path))
    throw InputError(path.string() + ": does not exist yet; make it with " + program);
  return path;
}

}  // namespace planar
