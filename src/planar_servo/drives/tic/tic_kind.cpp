#include "planar_servo/drives/tic/tic_kind.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/drives/home_fields.h"
#include "planar_servo/drives/tic/tic_doctor.h"
#include "planar_servo/drives/tic/tic_drives.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

/// Below, an ordinary machine's pauses would stop the arm; above, a lost drive runs on for too
/// long.
constexpr double kMinCommandTimeout_ms = 100.0;
constexpr double kMaxCommandTimeout_ms = 2000.0;

struct TicDetails final : DeviceDetails {
  TicSettings settings;
};

std::array<TicSettings, 3> all_settings(const CellSettings& cell) {
  return {tic_settings(cell.drives[0]), tic_settings(cell.drives[1]), tic_settings(cell.drives[2])};
}

}  // namespace

const TicSettings& tic_settings(const DriveSettings& drive) {
  return static_cast<const TicDetails&>(*drive.details).settings;
}

std::string TicKind::new_keys(std::size_t joint, double mark_deg) const {
  return fmt::format(
             R"(    serial: "0000000{}"             # serial number of this joint's Tic, as ticcmd --list tells
    command_timeout_ms: 250        # silence after which the Tic stops by itself
)",
             joint + 1) +
         new_home(mark_deg);
}

void TicKind::read(Fields& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<TicDetails>();
  TicSettings& settings = details->settings;
  drive.text("serial", settings.serial);
  for (std::size_t i = 0; i < joint; ++i) {
    const bool same =
        cell.drives[i].kind == this && tic_settings(cell.drives[i]).serial == settings.serial;
    drive.check(!same, fmt::format("drives[{}] has the serial number '{}' of drives[{}]; each "
                                   "joint needs a drive of its own",
                                   joint, settings.serial, i));
  }
  drive.number("command_timeout_ms", settings.command_timeout_s, kMillisecond,
               Range::from_to(kMinCommandTimeout_ms, kMaxCommandTimeout_ms));
  cell.drives[joint].details = details;
  list_home(drive, cell.transmission.drives[joint]);
}

std::shared_ptr<DriveGroup> TicKind::open(const CellSettings& cell,
                                          const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<TicDrives>(all_settings(cell));
}

std::vector<Finding> TicKind::examine(const CellSettings& cell) const {
  return examine_tics(cell.transmission, all_settings(cell));
}

}  // namespace planar
