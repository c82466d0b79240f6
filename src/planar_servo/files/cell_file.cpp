#include "planar_servo/files/cell_file.h"

#include <fmt/format.h>

#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/yaml_reader.h"

namespace planar {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::max();
constexpr double kTiny = 1e-9;  // the least value of what must be positive
constexpr int kMaxSensorPixels = 65535;
/// Below, an ordinary machine's pauses would stop the arm; above, a lost drive runs on for too
/// long.
constexpr double kMinCommandTimeout_ms = 100.0;
constexpr double kMaxCommandTimeout_ms = 2000.0;
constexpr int kMaxPacketSize = 65535;

CameraConnection read_connection(const YamlNode& node) {
  CameraConnection connection;
  if (node.has("address")) connection.address = node.text("address");
  if (node.has("id")) connection.id = node.text("id");
  connection.exposure_s = node.number_in("exposure_us", 1.0, kUnbounded) * kMicrosecond;
  connection.gain_db = node.number("gain_db");
  connection.pixel_format = node.choice(
      "pixel_format",
      {"Mono8", "Mono10", "Mono10p", "Mono10Packed", "Mono12", "Mono12p", "Mono12Packed"});
  connection.trigger = node.choice("trigger", {"free_run", "software", "hardware"});
  if (node.has("packet_size"))
    connection.packet_size = static_cast<int>(node.number_in("packet_size", 0, kMaxPacketSize));
  return connection;
}

CameraSettings read_camera(const YamlNode& node) {
  CameraSettings camera;
  camera.source = node.choice("source", {"virtual", "files", "aravis"});
  camera.width_px = static_cast<int>(node.number_in("width_px", 1, kMaxSensorPixels));
  camera.height_px = static_cast<int>(node.number_in("height_px", 1, kMaxSensorPixels));
  camera.pixel_pitch_m = node.number_in("pixel_pitch_um", kTiny, kUnbounded) * kMicrometre;
  camera.frame_rate_hz = node.number_in("frame_rate_hz", kTiny, kUnbounded);
  camera.timeout_s = node.number_in("timeout_ms", kTiny, kUnbounded) * kMillisecond;
  camera.follow_region_px =
      static_cast<int>(node.number_in("follow_region_px", 64, kMaxSensorPixels));
  camera.gain_e_per_level = node.number_in("gain_e_per_level", kTiny, kUnbounded);
  if (camera.source == "aravis") camera.connection = read_connection(node);
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
  const auto sense = node.choice("positive_rotation", {"counterclockwise", "clockwise"});
  arm.geometry.positive_rotation =
      sense == "clockwise" ? Rotation::kClockwise : Rotation::kCounterclockwise;
  arm.elbow = node.choice("elbow", {"left", "right"}) == "left" ? Elbow::kLeft : Elbow::kRight;
  const auto home = node.numbers("home_deg", 3);
  arm.home = Joints(home[0], home[1], home[2]) * kDegree;
  return arm;
}

Coupling coupling_named(const YamlNode& node) {
  const std::string name = node.as_text();
  if (name != "relative" && name != "absolute")
    node.add_fault(fmt::format("arm.coupling has '{}'; allowed are relative, absolute", name));
  return name == "absolute" ? Coupling::kAbsolute : Coupling::kRelative;
}

MotorDrive read_drive(const YamlNode& node) {
  MotorDrive drive;
  drive.pulses_per_motor_turn = node.number_in("pulses_per_motor_turn", kTiny, kUnbounded);
  drive.gear_ratio = node.number_in("gear_ratio", kTiny, kUnbounded);
  drive.direction = node.choice("direction", {"1", "-1"}) == "1" ? 1 : -1;
  drive.max_speed_rad_s = node.number_in("max_speed_deg_s", kTiny, kUnbounded) * kDegree;
  drive.max_acceleration_rad_s2 =
      node.number_in("max_acceleration_deg_s2", kTiny, kUnbounded) * kDegree;
  return drive;
}

/// What only a Tic has. Serial numbers tell the drives apart, whatever socket they are plugged
/// into.
void read_tic(const YamlNode& node, CellSettings& cell, std::size_t joint) {
  DriveSettings& drive = cell.drives[joint];
  drive.serial = node.text("serial");
  for (std::size_t i = 0; i < joint; ++i)
    if (cell.drives[i].kind == "tic" && cell.drives[i].serial == drive.serial)
      node.add_fault(
          fmt::format("drives[{}] has the serial number '{}' of drives[{}]; each joint "
                      "has a drive of its own",
                      joint, drive.serial, i));
  drive.command_timeout_s =
      node.number_in("command_timeout_ms", kMinCommandTimeout_ms, kMaxCommandTimeout_ms) *
      kMillisecond;
  const YamlNode home = node.child("home");
  const auto reference = home.choice("reference", {"taught", "reverse_switch", "forward_switch"});
  MotorDrive& motor = cell.transmission.drives[joint];
  if (reference == "reverse_switch") motor.home = HomeReference::kReverseSwitch;
  if (reference == "forward_switch") motor.home = HomeReference::kForwardSwitch;
  motor.home_rad = home.number("at_deg") * kDegree;
}

void read_transmission(const YamlNode& root, CellSettings& cell) {
  const YamlNode arm = root.child("arm");
  const auto couplings = arm.list("coupling", 2);
  for (std::size_t i = 0; i < couplings.size(); ++i)
    cell.transmission.coupling[i] = coupling_named(couplings[i]);
  const auto limits = arm.list("joint_limits_deg", 3);
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const auto range = limits[i].as_numbers(2);
    if (!range) continue;
    if (!((*range)[0] < (*range)[1]))
      limits[i].add_fault(
          fmt::format("arm.joint_limits_deg[{}] is [{}, {}]; the lower limit must "
                      "be below the upper one",
                      i, (*range)[0], (*range)[1]));
    cell.transmission.limits_rad[i] = Eigen::Vector2d((*range)[0], (*range)[1]) * kDegree;
  }
  const auto drives = root.list("drives", 3);
  for (std::size_t i = 0; i < drives.size(); ++i) {
    cell.transmission.drives[i] = read_drive(drives[i]);
    cell.drives[i].kind = drives[i].choice("kind", {"virtual", "tic"});
    if (cell.drives[i].kind == "tic") read_tic(drives[i], cell, i);
  }
}

ServoSettings read_servo(const YamlNode& node) {
  ServoSettings servo;
  servo.law = node.choice("law", {"jacobian", "inverse"}) == "inverse" ? ServoLaw::kInverse
                                                                       : ServoLaw::kJacobian;
  servo.gain = node.number_in("gain", kTiny, 1.0);
  servo.tolerance_m = node.number_in("tolerance_mm", kTiny, kUnbounded) * kMillimetre;
  servo.max_iterations = static_cast<int>(node.number_in("max_iterations", 0, 1000));
  servo.max_step_m = node.number_in("max_step_mm", kTiny, kUnbounded) * kMillimetre;
  servo.settle_s = node.number_in("settle_ms", 0.0, kUnbounded) * kMillisecond;
  servo.frames_per_measurement =
      static_cast<int>(node.number_in("frames_per_measurement", 1, 1000));
  servo.approach = node.choice("approach", {"one_side", "direct"}) == "direct" ? Approach::kDirect
                                                                               : Approach::kOneSide;
  return servo;
}

Workspace read_workspace(const YamlNode& node) {
  Workspace workspace;
  workspace.radius_min_m = node.number_in("radius_min_mm", 0.0, kUnbounded) * kMillimetre;
  workspace.radius_max_m = node.number_in("radius_max_mm", kTiny, kUnbounded) * kMillimetre;
  if (workspace.radius_min_m >= workspace.radius_max_m)
    node.add_fault("workspace.radius_min_mm must be below radius_max_mm");
  for (const YamlNode& item : node.list("keep_out"))
    workspace.keep_out.push_back(
        {Eigen::Vector2d(item.number("x_mm"), item.number("y_mm")) * kMillimetre,
         item.number_in("radius_mm", kTiny, kUnbounded) * kMillimetre});
  return workspace;
}

void read_lamps_and_tracker(const YamlNode& root, CellSettings& cell) {
  const YamlNode lamps = root.child("lamps");
  const auto diameters = lamps.numbers("diameter_mm", 2);
  cell.lamp_diameters_m = {diameters[0] * kMillimetre, diameters[1] * kMillimetre};
  cell.lamp_separation_m = lamps.number_in("separation_mm", kTiny, kUnbounded) * kMillimetre;
  const YamlNode tracker = root.child("tracker");
  cell.tracker_sigma_m = tracker.number_in("sigma_mm", 0.0, kUnbounded) * kMillimetre;
  cell.tracker_sigma_m_per_m = tracker.number_in("sigma_mm_per_m", 0.0, kUnbounded) * kMillimetre;
  for (const YamlNode& item : root.list("datum"))
    cell.datum.push_back({item.text("id"), Eigen::Vector3d(item.number("x_mm"), item.number("y_mm"),
                                                           item.number("z_mm")) *
                                               kMillimetre});
}

/// A virtual drive finds the place where it stood at first.
void give_virtual_drives_switches(CellSettings& cell) {
  const Eigen::Vector3d motors = Transmission(cell.transmission).motors_from_joints(cell.arm.home);
  for (int i = 0; i < 3; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (cell.drives[joint].kind != "virtual") continue;
    cell.transmission.drives[joint].home = HomeReference::kReverseSwitch;
    cell.transmission.drives[joint].home_rad = motors[i];
  }
}

}  // namespace

double CellSettings::tracker_sigma_at(double range_m) const {
  return tracker_sigma_m + tracker_sigma_m_per_m * range_m;
}

CellSettings read_cell(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "cell");
  const YamlNode root = document.root();
  CellSettings cell;
  cell.file = path;
  const auto beside = [&](const char* key) { return path.parent_path() / root.text(key); };
  cell.camera = read_camera(root.child("camera"));
  cell.camera_model = beside("camera_model");
  cell.workplane = beside("workplane");
  cell.tool = beside("tool");
  cell.error_map = beside("error_map");
  cell.arm = read_arm(root.child("arm"));
  read_transmission(root, cell);
  cell.tool_orientation = root.number("tool_orientation_deg") * kDegree;
  cell.servo = read_servo(root.child("servo"));
  cell.workspace = read_workspace(root.child("workspace"));
  read_lamps_and_tracker(root, cell);
  if (root.has("virtual")) cell.truth = beside("virtual");
  document.throw_if_faulty();
  give_virtual_drives_switches(cell);
  return cell;
}

const std::filesystem::path& require_made(const std::filesystem::path& path,
                                          const std::string& program) {
  if (!std::filesystem::exists(path))
    throw InputError(path.string() + ": does not exist yet; make it with " + program);
  return path;
}

}  // namespace planar
