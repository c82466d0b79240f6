#include "planar_servo/drives/grbl_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/drives/grbl_board.h"
#include "planar_servo/drives/grbl_drives.h"
#include "planar_servo/drives/home_fields.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

using Verdict = Finding::Verdict;

constexpr const char* kSubject = "drives";

constexpr const char* kSeeDrives = "see doc/drives.md";

constexpr Named<char> kAxes[] = {{'X', "X"}, {'Y', "Y"}, {'Z', "Z"}};
/// A board at full speed needs this time to brake and keeps its reserve besides.
constexpr double kLongestBraking_s = grbl::kLongestRun_s - grbl::kReserve_s;

struct GrblDetails final : DeviceDetails {
  std::string port;
  int baud{115200};
  char axis{'X'};
  double pulses_per_mm{250.0};
};

const GrblDetails& details_of(const DriveSettings& drive) {
  return static_cast<const GrblDetails&>(*drive.details);
}

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

/// Checks that a joint is another axis of the same board, and found as the other one.
void check_board(Fields& drive, const CellSettings& cell, std::size_t joint, std::size_t other) {
  const GrblDetails& details = details_of(cell.drives[joint]);
  const GrblDetails& first = details_of(cell.drives[other]);
  drive.check(details.port == first.port && details.baud == first.baud,
              {fmt::format("drives[{}] has another port or baud than drives[{}]", joint, other),
               "the three joints are axes of one board"});
  drive.check(details.axis != first.axis,
              {fmt::format("drives[{}] is axis {} as drives[{}]", joint, details.axis, other),
               "each joint needs an axis of its own"});
  const auto taught = [&](std::size_t i) {
    return cell.transmission.drives[i].home == HomeReference::kTaught;
  };
  drive.check(taught(joint) == taught(other),
              {fmt::format("drives[{}] and drives[{}] must both be taught or both have a home "
                           "switch, because Grbl searches the switches of all axes",
                           joint, other)});
}

/// Checks that a board whose program has died brings the motor to rest in time.
void check_braking(Fields& drive, const MotorDrive& motor) {
  const double braking_s = motor.max_speed_rad_s / motor.max_acceleration_rad_s2;
  drive.check(
      braking_s <= kLongestBraking_s * (1.0 + 1e-9),
      {fmt::format("max_speed_deg_s is {:g}", motor.max_speed_rad_s / kDegree),
       fmt::format(
           "it may be at most {:g}, which is {:g} s of max_acceleration_deg_s2: a Grbl board runs "
           "on with what is queued when its program dies, and must rest within 0.2 s",
           kLongestBraking_s * motor.max_acceleration_rad_s2 / kDegree, kLongestBraking_s)},
      "max_speed_deg_s");
}

}  // namespace

std::vector<Finding> examine_grbl(const GrblSettings& settings) {
  try {
    const GrblBoard board(settings.port, settings.baud);
    if (const auto unfit = grbl::unfitness(board.version(), board.settings(), settings))
      return {faulty(kSubject, *unfit, kSeeDrives)};
    return {{Verdict::kWell, kSubject,
             fmt::format("{} at {}, its settings as the cell's; like after every opening, it is to "
                         "be homed before it moves",
                         board.version().version, settings.port)}};
  } catch (const WorkError& error) {
    return {faulty(kSubject, error.refusal(), kSeeDrives)};
  }
}

GrblSettings grbl_settings(const CellSettings& cell) {
  const GrblDetails& first = details_of(cell.drives[0]);
  GrblSettings settings{first.port, first.baud, {}};
  const Eigen::Vector3d pulses_per_rad = Transmission(cell.transmission).pulses_per_rad();
  for (std::size_t i = 0; i < 3; ++i) {
    const MotorDrive& motor = cell.transmission.drives[i];
    const GrblDetails& details = details_of(cell.drives[i]);
    const double scale = std::abs(pulses_per_rad[static_cast<int>(i)]);
    settings.axes[i] = {details.axis, details.pulses_per_mm, scale * motor.max_speed_rad_s,
                        scale * motor.max_acceleration_rad_s2, motor.home};
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
  list_home(drive, cell.transmission.drives[joint]);
  check_braking(drive, cell.transmission.drives[joint]);
  for (std::size_t i = 0; i < joint; ++i)
    if (cell.drives[i].kind == this) check_board(drive, cell, joint, i);
}

std::shared_ptr<DriveGroup> GrblKind::open(const CellSettings& cell,
                                           const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<GrblDrives>(grbl_settings(cell));
}

std::vector<Finding> GrblKind::examine(const CellSettings& cell) const {
  return examine_grbl(grbl_settings(cell));
}

}  // namespace planar
