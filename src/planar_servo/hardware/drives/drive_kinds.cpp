#include "planar_servo/hardware/drives/drive_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/drives/grbl_board.h"
#include "planar_servo/hardware/drives/grbl_drives.h"

namespace planar {
namespace {

using Verdict = Finding::Verdict;

constexpr Named<HomeReference> kReferences[] = {{HomeReference::kTaught, "taught"},
                                                {HomeReference::kReverseSwitch, "reverse_switch"},
                                                {HomeReference::kForwardSwitch, "forward_switch"},
                                                {HomeReference::kSight, "sight"}};

constexpr const char* kSubject = "drives";
constexpr const char* kSeeDrives = "see doc/drives.md";

constexpr Named<char> kAxes[] = {{'X', "X"}, {'Y', "Y"}, {'Z', "Z"}};
/// The time that a board at full speed may take to brake, besides its reserve.
constexpr double kLongestBraking_s = grbl::kLongestRun_s - grbl::kReserve_s;

struct GrblDetails final : DeviceDetails {
  std::string port;
  int baud{115200};
  char axis{'X'};
  double pulses_per_mm{250.0};
};

void check_line(Fields& drive, const GrblDetails& details) {
  const std::vector<int> bauds = SerialLine::bauds();
  drive.check(std::find(bauds.begin(), bauds.end(), details.baud) != bauds.end(),
              {fmt::format("baud is {}", details.baud),
               fmt::format("one of {} is needed", fmt::join(bauds, ", "))},
              "baud");
  drive.check(grbl::keeps_pulses(details.pulses_per_mm),
              {fmt::format("pulses_per_mm is {:g}", details.pulses_per_mm),
               "it must divide 1000, such as 250, because Grbl counts thousandths of a millimetre "
               "and would lose pulses"},
              "pulses_per_mm");
}

/// Checks that a joint is another axis of the same board, and is homed like the other one.
void check_board(Fields& drive, const CellSettings& cell, std::size_t joint, std::size_t other) {
  const auto& details = details_of<GrblDetails>(cell.drives[joint]);
  const auto& first = details_of<GrblDetails>(cell.drives[other]);
  drive.check(details.port == first.port && details.baud == first.baud,
              {fmt::format("drives[{}] has another port or baud than drives[{}]", joint, other),
               "the three joints are axes of one board", "", Cause::kContradiction});
  drive.check(details.axis != first.axis,
              {fmt::format("drives[{}] is axis {} as drives[{}]", joint, details.axis, other),
               "each joint needs an axis of its own", "", Cause::kExists});
  const auto taught = [&](std::size_t i) { return !is_switch(cell.transmission.drives[i].home); };
  drive.check(taught(joint) == taught(other),
              {fmt::format("drives[{}] and drives[{}] must both be taught or both have a home "
                           "switch, because Grbl searches the switches of all axes",
                           joint, other),
               "", "", Cause::kContradiction});
}

/// Checks that a board whose program has died brings the motor to rest in time.
void check_braking(Fields& drive, const MotorDrive& motor) {
  const double braking_s = motor.max_speed_rad_s / motor.max_acceleration_rad_s2;
  drive.check(
      braking_s <= kLongestBraking_s * (1.0 + 1e-9),
      {fmt::format("max_speed_deg_s is {:g}", motor.max_speed_rad_s / kDegree),
       fmt::format(
           "it may be at most {:g}, which is {:g} s of max_acceleration_deg_s2: when its program "
           "dies, a Grbl board finishes what is queued, and must rest within 0.2 s",
           kLongestBraking_s * motor.max_acceleration_rad_s2 / kDegree, kLongestBraking_s)},
      "max_speed_deg_s");
}

/// What the letters of a board's inputs mean, where they keep its motors from turning [Grbl wiki,
/// Interface; grblHAL wiki, Report extensions].
constexpr Named<char> kInputs[] = {{'X', "limit X"},     {'Y', "limit Y"},       {'Z', "limit Z"},
                                   {'D', "safety door"}, {'H', "feed hold"},     {'R', "reset"},
                                   {'F', "motor fault"}, {'E', "emergency stop"}};

/// Judges the inputs that are on while the board rests.
std::vector<Finding> examine_inputs(const std::string& on) {
  std::vector<std::string> names;
  for (const auto& [letter, name] : kInputs)
    if (on.find(letter) != std::string::npos) names.emplace_back(name);
  if (names.empty()) return {};
  return {
      {{fmt::format("inputs are on at rest: {}", fmt::join(names, ", ")),
        "unless the arm stands at these switches, or somebody presses them: look for a bad "
        "switch or cable; if they open when pressed, change $5 (limits) or $14 (others, grblHAL)",
        kSubject},
       Verdict::kDoubtful}};
}

}  // namespace

std::string new_home(double mark_deg) {
  return fmt::format(
      R"(    home:
      reference: taught            # taught (by hand), reverse_switch, forward_switch, sight
      at_deg: {:<20g} # motor's angle behind its gear at that mark or switch
)",
      mark_deg);
}

void list_home(Fields& drive, CellSettings& cell, std::size_t joint) {
  MotorDrive& motor = cell.transmission.drives[joint];
  const Eigen::Vector2d limits_deg = cell.transmission.limits_rad[joint] / kDegree;
  drive.map("home", [&] {
    drive.choice("reference", motor.home, kReferences);
    const bool is_needed = motor.home != HomeReference::kSight || drive.given("at_deg", false);
    if (!is_needed || !drive.number("at_deg", motor.home_rad, kDegree)) return;
    const double at_deg = motor.home_rad / kDegree;
    drive.check(std::max(limits_deg.x() - at_deg, at_deg - limits_deg.y()) <= 360.0,
                {fmt::format("at_deg is {:g}, over a turn beyond joint_limits_deg [{:g}, {:g}]",
                             at_deg, limits_deg.x(), limits_deg.y()),
                 "write the motor's angle behind its gear there, in degrees"},
                "at_deg");
  });
}

std::vector<Finding> examine_grbl(const GrblSettings& settings) {
  try {
    GrblBoard board(settings.port, settings.baud);
    const std::string who = fmt::format("{} at {}", board.version().version, settings.port);
    Finding found{
        {who + ", with the cell's settings; as after every opening, home it before it moves", "",
         kSubject},
        Verdict::kWell};
    if (const auto unfit = grbl::unfitness(board.settings(), settings))
      found = faulty(kSubject, unfit->at(who));
    else if (!grbl::is_supported(board.version()))
      found = {{who + ", which is untried here",
                "turn each joint by planar-jog with nothing in the arm's way", kSubject},
               Verdict::kDoubtful};
    std::vector<Finding> findings = examine_inputs(board.inputs_on());
    findings.insert(findings.begin(), found);
    return findings;
  } catch (const WorkError& error) {
    return {faulty(kSubject, error.refusal(), kSeeDrives)};
  }
}

GrblSettings grbl_settings(const CellSettings& cell) {
  const auto& first = details_of<GrblDetails>(cell.drives[0]);
  GrblSettings settings{first.port, first.baud, {}};
  const auto limits = Transmission(cell.transmission).rated_limits();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& details = details_of<GrblDetails>(cell.drives[i]);
    settings.axes[i] = {details.axis, details.pulses_per_mm, limits[i].speed_pulses_s,
                        limits[i].acceleration_pulses_s2, cell.transmission.drives[i].home};
  }
  return settings;
}

std::string GrblKind::new_keys(std::size_t joint, double mark_deg) const {
  return fmt::format(
             R"(    port: /dev/serial/by-id/BOARD  # the one board of all joints
    baud: 115200                   # its speed, the same in all joints
    axis: {:<24} # the board's axis that turns this joint
    pulses_per_mm: 250             # its setting $100 to $102; must divide 1000
)",
             kAxes[joint].name) +
         new_home(mark_deg);
}

void GrblKind::read(Fields& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<GrblDetails>();
  drive.text("port", details->port);
  const bool has_baud = drive.whole_number("baud", details->baud, 1);
  drive.choice("axis", details->axis, kAxes);
  const bool has_scale =
      drive.number("pulses_per_mm", details->pulses_per_mm, 1.0, Range::positive());
  if (has_baud && has_scale) check_line(drive, *details);
  cell.drives[joint].details = details;
  list_home(drive, cell, joint);
  check_braking(drive, cell.transmission.drives[joint]);
  for (std::size_t i = 0; i < joint; ++i)
    if (cell.drives[i].kind == this) check_board(drive, cell, joint, i);
}

std::shared_ptr<DriveGroup> GrblKind::open(const CellSettings& cell) const {
  return std::make_shared<GrblDrives>(grbl_settings(cell));
}

std::vector<Finding> GrblKind::examine(const CellSettings& cell) const {
  return examine_grbl(grbl_settings(cell));
}

namespace {

constexpr double kTimeout_s = 1.6;
/// Below, the pauses of an ordinary computer would stop the arm; above, a lost drive runs for too
/// long.
constexpr double kMinCommandTimeout_ms = 100.0;
constexpr double kMaxCommandTimeout_ms = 2000.0;

Finding examine_tic(TicBus& bus, const std::string& subject, const std::string& serial) {
  const TicInspection tic = inspect_tic(bus, serial);
  if (tic.refusal) return faulty(subject, *tic.refusal, kSeeDrives);
  const std::string what = fmt::format(
      "{} {} at {}, firmware {}, supply {:.1f} V", tic::product_name(tic.listing.product_id),
      serial, tic.listing.device, tic::firmware_name(tic.listing.firmware), tic.supply_v);
  if (!tic.faults.empty())
    return faulty(subject,
                  {fmt::format("{}: {}", what, fmt::join(tic.faults, ", ")),
                   "remove the cause, then enable the drives with planar-jog", "", Cause::kDevice});
  if (!tic.position_certain)
    return {{what + "; it does not know where it stands", "home it with planar-jog", subject,
             Cause::kDevice},
            Verdict::kDoubtful};
  return {{what, "", subject}, Verdict::kWell};
}

/// Returns why a Tic cannot turn as fast as the cell requires; empty when it can.
std::string excess_of(const MotorDrive& motor, double pulses_per_rad) {
  try {
    tic::speed_units(std::abs(pulses_per_rad) * motor.max_speed_rad_s);
    tic::acceleration_units(std::abs(pulses_per_rad) * motor.max_acceleration_rad_s2);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

struct TicDetails final : DeviceDetails {
  TicSettings settings;
};

}  // namespace

TicInspection inspect_tic(TicBus& bus, const std::string& serial) {
  TicInspection inspection;
  Refusal why;
  const auto port = bus.open(serial, why);
  if (port == nullptr) {
    inspection.refusal = why;
    return inspection;
  }
  inspection.listing = port->listing;
  std::vector<TicTransfer> transfers(2);
  transfers[0] = {port.get(), tic::Command::kGetSettings};
  transfers[0].data.resize(tic::kSettingsBytes);
  transfers[1] = {port.get(), tic::Command::kGetVariables};
  transfers[1].data.resize(tic::StatusBlock::kBytes);
  bus.exchange(transfers, kTimeout_s);
  for (const TicTransfer& transfer : transfers)
    if (!transfer.error.empty())
      inspection.refusal = Refusal{transfer.error, "plug it in again, with another cable or hub",
                                   "", Cause::kDevice};
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
  return details_of<TicDetails>(drive).settings;
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
                        "each joint needs a drive of its own", "", Cause::kExists});
  }
  drive.number("command_timeout_ms", settings.command_timeout_s, kMillisecond,
               Range::from_to(kMinCommandTimeout_ms, kMaxCommandTimeout_ms));
  cell.drives[joint].details = details;
  list_home(drive, cell, joint);
}

std::shared_ptr<DriveGroup> TicKind::open(const CellSettings& cell) const {
  return std::make_shared<TicDrives>(std::array{
      tic_settings(cell.drives[0]), tic_settings(cell.drives[1]), tic_settings(cell.drives[2])});
}

std::vector<Finding> TicKind::examine(const CellSettings& cell) const {
  std::vector<Finding> findings;
  const Eigen::Vector3d pulses_per_rad = Transmission(cell.transmission).pulses_per_rad();
  try {
    TicBus bus;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string subject = fmt::format("drive {}", i + 1);
      findings.push_back(examine_tic(bus, subject, tic_settings(cell.drives[i]).serial));
      const std::string excess = excess_of(cell.transmission.drives[i], pulses_per_rad[i]);
      if (!excess.empty())
        findings.push_back(faulty(subject, {excess,
                                            "lower max_speed_deg_s and max_acceleration_deg_s2 in "
                                            "the cell file, or set fewer microsteps"}));
    }
  } catch (const WorkError& error) {
    findings.push_back(faulty(kSubject, error.refusal(), kSeeDrives));
  }
  return findings;
}

}  // namespace planar
