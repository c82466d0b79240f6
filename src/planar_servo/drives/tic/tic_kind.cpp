#include "planar_servo/drives/tic/tic_kind.h"

#include <fmt/format.h>

#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/drives/tic/tic_doctor.h"
#include "planar_servo/drives/tic/tic_drives.h"
#include "planar_servo/io/yaml_reader.h"

namespace planar {
namespace {

/// Below, an ordinary machine's pauses would stop the arm; above, a lost drive runs on for too
/// long.
constexpr double kMinCommandTimeout_ms = 100.0;
constexpr double kMaxCommandTimeout_ms = 2000.0;

constexpr Named<HomeReference> kReferences[] = {{HomeReference::kTaught, "taught"},
                                                {HomeReference::kReverseSwitch, "reverse_switch"},
                                                {HomeReference::kForwardSwitch, "forward_switch"}};

struct TicDetails final : DeviceDetails {
  TicSettings settings;
};

}  // namespace

const TicSettings& tic_settings(const DriveSettings& drive) {
  return static_cast<const TicDetails&>(*drive.details).settings;
}

void TicKind::read(const YamlNode& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<TicDetails>();
  const std::string serial = drive.text("serial");
  for (std::size_t i = 0; i < joint; ++i) {
    if (cell.drives[i].kind == this && tic_settings(cell.drives[i]).serial == serial)
      drive.add_fault(
          fmt::format("drives[{}] has the serial number '{}' of drives[{}]; each joint needs a "
                      "drive of its own",
                      joint, serial, i));
  }
  details->settings.serial = serial;
  details->settings.command_timeout_s =
      drive.number_in("command_timeout_ms", kMinCommandTimeout_ms, kMaxCommandTimeout_ms) *
      kMillisecond;
  cell.drives[joint].details = details;
  const YamlNode home = drive.child("home");
  MotorDrive& motor = cell.transmission.drives[joint];
  motor.home = home.choice("reference", kReferences);
  motor.home_rad = home.number("at_deg") * kDegree;
}

static std::array<TicSettings, 3> all_settings(const CellSettings& cell) {
  return {tic_settings(cell.drives[0]), tic_settings(cell.drives[1]), tic_settings(cell.drives[2])};
}

std::shared_ptr<DriveGroup> TicKind::open(const CellSettings& cell,
                                          const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<TicDrives>(all_settings(cell));
}

std::vector<Finding> TicKind::examine(const CellSettings& cell) const {
  return examine_tics(cell.transmission, all_settings(cell));
}

}  // namespace planar
