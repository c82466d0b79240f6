#include "planar_servo/machine/virtual_kinds.h"

#include <fmt/format.h>

#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {
namespace {

constexpr char kVirtual[] = "is virtual; there is no device to examine";

class NoTracker final : public Tracker {
 public:
  TrackerAnswer measure_tool(const std::string& /*place*/) override { return refused(); }
  TrackerAnswer measure_monument(const std::string& /*id*/) override { return refused(); }

 private:
  static TrackerAnswer refused() { return TrackerAnswer::failed("tracker.source is none"); }
};

}  // namespace

VirtualHardware virtual_hardware(const CellSettings& cell) {
  VirtualHardware hardware;
  hardware.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  hardware.frame_rate_hz = cell.camera.frame_rate_hz;
  hardware.sense = PlanarArm(cell.arm.geometry).sense();
  for (std::size_t i = 0; i < 2; ++i)
    hardware.relative[i] = cell.transmission.coupling[i] == Coupling::kRelative;
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = cell.transmission.drives[static_cast<std::size_t>(i)];
    hardware.pulses_per_motor_turn[i] = drive.pulses_per_motor_turn;
    hardware.gear_ratios[i] = drive.gear_ratio;
    hardware.directions[i] = drive.direction;
    hardware.max_speed_rad_s[i] = drive.max_speed_rad_s;
    hardware.max_acceleration_rad_s2[i] = drive.max_acceleration_rad_s2;
  }
  hardware.home_rad = cell.arm.home;
  for (const Monument& monument : cell.datum)
    hardware.monuments_B.emplace_back(monument.id, monument.p_B);
  return hardware;
}

// The devices below are parts of the world and keep it alive.

std::shared_ptr<FrameSource> VirtualCameraKind::open(
    const CellSettings& /*cell*/, const std::shared_ptr<VirtualCell>& world) const {
  return {world, &world->camera()};
}

std::vector<Finding> VirtualCameraKind::examine(const CellSettings& /*cell*/) const {
  return {{Finding::Verdict::kWell, "camera", kVirtual}};
}

void VirtualDriveKind::complete(CellSettings& cell, std::size_t joint) const {
  const Eigen::Vector3d motors = Transmission(cell.transmission).motors_from_joints(cell.arm.home);
  MotorDrive& motor = cell.transmission.drives[joint];
  motor.home = HomeReference::kReverseSwitch;
  motor.home_rad = motors[static_cast<Eigen::Index>(joint)];
}

std::shared_ptr<DriveGroup> VirtualDriveKind::open(
    const CellSettings& /*cell*/, const std::shared_ptr<VirtualCell>& world) const {
  return {world, &world->drives()};
}

std::vector<Finding> VirtualDriveKind::examine(const CellSettings& cell) const {
  std::vector<Finding> findings;
  for (std::size_t i = 1; i <= cell.drives.size(); ++i)
    findings.push_back({Finding::Verdict::kWell, fmt::format("drive {}", i), kVirtual});
  return findings;
}

std::shared_ptr<Tracker> VirtualTrackerKind::open(const CellSettings& /*cell*/,
                                                  const std::shared_ptr<VirtualCell>& world) const {
  return {world, &world->tracker()};
}

std::vector<Finding> VirtualTrackerKind::examine(const CellSettings& /*cell*/) const {
  return {{Finding::Verdict::kWell, "tracker", kVirtual}};
}

std::shared_ptr<Tracker> NoTrackerKind::open(const CellSettings& /*cell*/,
                                             const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<NoTracker>();
}

std::vector<Finding> NoTrackerKind::examine(const CellSettings& /*cell*/) const {
  return {{Finding::Verdict::kWell, "tracker",
           "there is none (tracker.source); planar-record takes poses and board views only"}};
}

}  // namespace planar
