#include "planar_servo/drives/tic_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/cell/device_kinds.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/drives/home_fields.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

constexpr double kTimeout_s = 1.6;
/// Below, an ordinary machine's pauses would stop the arm; above, a lost drive runs on for too
/// long.
constexpr double kMinCommandTimeout_ms = 100.0;
constexpr double kMaxCommandTimeout_ms = 2000.0;

using Verdict = Finding::Verdict;

Finding examine_tic(TicBus& bus, const std::string& subject, const std::string& serial) {
  const TicInspection tic = inspect_tic(bus, serial);
  if (tic.refusal) return faulty(subject, *tic.refusal, "see doc/drives.md");
  const std::string what = fmt::format(
      "{} {} at {}, firmware {}, supply {:.1f} V", tic::product_name(tic.listing.product_id),
      serial, tic.listing.device, tic::firmware_name(tic.listing.firmware), tic.supply_v);
  if (!tic.faults.empty())
    return {Verdict::kFaulty, subject, fmt::format("{}: {}", what, fmt::join(tic.faults, ", ")),
            "remove the cause, then enable the drives with planar-jog"};
  if (!tic.position_certain)
    return {Verdict::kDoubtful, subject, what + "; it does not know where it stands",
            "home it with planar-jog"};
  return {Verdict::kWell, subject, what};
}

/// Why a Tic cannot turn as fast as the cell asks; empty when it can.
std::string excess_of(const MotorDrive& motor, double pulses_per_rad) {
  try {
    tic::speed_units(std::abs(pulses_per_rad) * motor.max_speed_rad_s);
    tic::acceleration_units(std::abs(pulses_per_rad) * motor.max_acceleration_rad_s2);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// Presence, permission, firmware, settings, supply and errors of every Tic, and whether the speeds
/// of the transmission are within what a Tic can do. Nothing moves and nothing is switched on.
std::vector<Finding> examine_tics(const TransmissionSettings& transmission,
                                  const std::array<TicSettings, 3>& tics) {
  std::vector<Finding> findings;
  const Eigen::Vector3d pulses_per_rad = Transmission(transmission).pulses_per_rad();
  TicBus bus;
  for (int i = 0; i < 3; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const std::string subject = fmt::format("drive {}", i + 1);
    findings.push_back(examine_tic(bus, subject, tics[joint].serial));
    const std::string excess = excess_of(transmission.drives[joint], pulses_per_rad[i]);
    if (!excess.empty())
      findings.push_back({Verdict::kFaulty, subject, excess,
                          "lower max_speed_deg_s and max_acceleration_deg_s2 in the cell file, or "
                          "set fewer microsteps"});
  }
  return findings;
}

struct TicDetails final : DeviceDetails {
  TicSettings settings;
};

std::array<TicSettings, 3> all_settings(const CellSettings& cell) {
  return {tic_settings(cell.drives[0]), tic_settings(cell.drives[1]), tic_settings(cell.drives[2])};
}

}  // namespace

TicInspection inspect_tic(TicBus& bus, const std::string& serial) {
  TicInspection inspection;
  Refusal why;
  const auto port = bus.open(serial, why);
  if (port == nullptr) {
    inspection.refusal = why;
    return inspection;
  }
  inspection.listing = port->listing();
  std::vector<TicTransfer> transfers(2);
  transfers[0] = {port.get(), tic::Command::kGetSettings};
  transfers[0].data.resize(tic::kSettingsBytes);
  transfers[1] = {port.get(), tic::Command::kGetVariables};
  transfers[1].data.resize(tic::StatusBlock::kBytes);
  bus.exchange(transfers, kTimeout_s);
  for (const TicTransfer& transfer : transfers)
    if (!transfer.error.empty())
      inspection.refusal = Refusal{transfer.error, "plug it in again, with another cable or hub"};
  if (inspection.refusal) return inspection;
  inspection.refusal = tic::unfitness(inspection.listing.firmware, transfers[0].data);
  tic::StatusBlock::Bytes bytes{};
  std::copy(transfers[1].data.begin(), transfers[1].data.end(), bytes.begin());
  const tic::StatusBlock status(bytes);
  inspection.supply_v = status.supply_v();
  inspection.position_certain = status.position_certain();
  inspection.faults = status.standing_faults();
  return inspection;
}

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
    drive.check(!same, {fmt::format("drives[{}] has the serial number '{}' of drives[{}]", joint,
                                    settings.serial, i),
                        "each joint needs a drive of its own"});
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
