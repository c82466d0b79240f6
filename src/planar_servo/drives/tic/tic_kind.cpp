#include "planar_servo/drives/tic/tic_kind.h"

#include <fmt/format.h>

#include "planar_servo/cell/cell_settings.h"
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

/// The Tic's settings of a joint; null when its drive is of another kind.
const TicSettings* tic_of(const CellSettings& cell, std::size_t joint) {
  const auto* details = dynamic_cast<const TicDetails*>(cell.drives[joint].details.get());
  return details == nullptr ? nullptr : &details->settings;
}

std::array<TicSettings, 3> tic_settings(const CellSettings& cell) {
  return {*tic_of(cell, 0), *tic_of(cell, 1), *tic_of(cell, 2)};
}

}  // namespace

void TicKind::read(const YamlNode& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<TicDetails>();
  const std::string serial = drive.text("serial");
  for (std::size_t i = 0; i < joint; ++i) {
    const TicSettings* other = tic_of(cell, i);
    if (other != nullptr && other->serial == serial)
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

std::shared_ptr<DriveGroup> TicKind::open(const CellSettings& cell,
                                          const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<TicDrives>(tic_settings(cell));
}

std::vector<Finding> TicKind::examine(const CellSettings& cell) const {
  return examine_tics(cell.transmission, tic_settings(cell));
}

}  // namespace planar
