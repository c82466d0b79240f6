#include "planar_servo/hardware/links/link_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/drives/drive_kinds.h"
#include "planar_servo/hardware/links/command_link.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "planar_servo/hardware/links/linuxcnc_link.h"
#include "planar_servo/hardware/links/modbus_link.h"

namespace planar {
namespace {

constexpr const char* kDrives = "drives";
constexpr double kLeastAnswer_ms = 20.0, kMostAnswer_ms = 2000.0;

std::array<DriveLimits, 3> limits_of(const CellSettings& cell) {
  return Transmission(cell.transmission).rated_limits();
}

/// Checks that two joints say the same of the machine that moves them; each key comes with whether
/// they do.
void check_alike(Fields& drive, std::size_t joint, std::size_t other,
                 std::initializer_list<std::pair<const char*, bool>> keys, const char* rule) {
  for (const auto& [key, is_alike] : keys)
    drive.check(is_alike,
                {fmt::format("drives[{}] has another {} than drives[{}]", joint, key, other), rule,
                 "", Cause::kContradiction},
                key);
}

/// Returns how many counts beside its target a motor may rest that tells where it is: closed loops
/// report that they are there within about a degree of the motor.
int in_position_counts(const CellSettings& cell) {
  constexpr double kPerTurn = 1.0 / 360.0;
  const auto& [first, second, third] = cell.transmission.drives;
  const double least = std::min(
      {first.pulses_per_motor_turn, second.pulses_per_motor_turn, third.pulses_per_motor_turn});
  return static_cast<int>(std::ceil(kPerTurn * least));
}

struct CommandDetails final : DeviceDetails {
  MotionProgram program;
};

std::string name_of(const MotionProgram& program) {
  return fmt::format("the program {}", fmt::join(program.words, " "));
}

/// Opens the link to a machine and says how it is; `judge(link, state)` does where it has no fault.
template <typename Link, typename Machine, typename Judge>
std::vector<Finding> examine_link(const Machine& machine, const std::string& place,
                                  const char* remedy, const char* manual, const Judge& judge) {
  try {
    Link link(machine);
    const MachineState state = link.read();
    if (state.faults.empty()) return {judge(link, state)};
    return {faulty(kDrives, {state.faults.front(), remedy, place, Cause::kDevice})};
  } catch (const WorkError& error) {
    return {faulty(kDrives, place.empty() ? error.refusal() : error.refusal().at(place), manual)};
  }
}

Finding well(const std::string& what, const MachineState& state, const std::string& doubt = "") {
  return {{fmt::format("{}, at {} counts, {}", what, fmt::join(state.counts, ", "),
                       state.on ? "switched on" : "off"),
           doubt, kDrives},
          doubt.empty() ? Finding::Verdict::kWell : Finding::Verdict::kDoubtful};
}

}  // namespace

std::string CommandKind::new_keys(std::size_t /*joint*/, double mark_deg) const {
  return R"(    program: [python3, motion.py]  # your program and its arguments; see doc/motion_program.md
    answer_ms: 200                 # how long an answer of it may take
)" + new_home(mark_deg);
}

void CommandKind::read(Fields& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<CommandDetails>();
  MotionProgram& program = details->program;
  drive.texts("program", program.words);
  drive.check(
      !program.words.empty(),
      {"program names nothing", "give the program and its arguments, such as [python3, motion.py]"},
      "program");
  if (drive.given("answer_ms", false))
    drive.number("answer_ms", program.answer_s, kMillisecond,
                 Range::from_to(kLeastAnswer_ms, kMostAnswer_ms));
  program.folder = std::filesystem::absolute(cell.file).parent_path();
  cell.drives[joint].details = details;
  list_home(drive, cell, joint);
  for (std::size_t i = 0; i < joint; ++i)
    if (cell.drives[i].kind == this)
      check_alike(
          drive, joint, i,
          {{"program", details_of<CommandDetails>(cell.drives[i]).program.words == program.words}},
          "one program moves the three joints");
}

std::shared_ptr<DriveGroup> CommandKind::open(const CellSettings& cell) const {
  const MotionProgram& program = details_of<CommandDetails>(cell.drives[0]).program;
  return std::make_shared<LinkedDrives>(
      name_of(program), limits_of(cell),
      [program] { return std::make_unique<CommandLink>(program); }, in_position_counts(cell));
}

std::vector<Finding> CommandKind::examine(const CellSettings& cell) const {
  const MotionProgram& program = details_of<CommandDetails>(cell.drives[0]).program;
  return examine_link<CommandLink>(
      program, name_of(program), "remove the cause", "see doc/motion_program.md",
      [](const auto& link, const auto& state) { return well(link.machine(), state); });
}

namespace {

constexpr int kLowestAddress = 1, kHighestAddress = 247;
constexpr Named<char> kParities[] = {{'N', "none"}, {'E', "even"}, {'O', "odd"}};

/// What one item of `drives` says of its driver and the line.
struct ModbusDetails final : DeviceDetails {
  ModbusLine line;
  std::string registers;  ///< the map's file, beside the cell's
  int address{0};         ///< 0 while it is not read
};

/// Checks that a joint is another driver on the same line.
void check_line(Fields& drive, const CellSettings& cell, std::size_t joint, std::size_t other) {
  const ModbusDetails& one = details_of<ModbusDetails>(cell.drives[joint]);
  const ModbusDetails& first = details_of<ModbusDetails>(cell.drives[other]);
  check_alike(drive, joint, other,
              {{"port", one.line.port == first.line.port},
               {"baud", one.line.baud == first.line.baud},
               {"parity", one.line.parity == first.line.parity},
               {"stop_bits", one.line.stop_bits == first.line.stop_bits},
               {"answer_ms", one.line.answer_s == first.line.answer_s},
               {"registers", one.registers == first.registers}},
              "the three drivers are of one make, on one line");
  drive.check(one.address == 0 || one.address != first.address,
              {fmt::format("drives[{}] has address {} as drives[{}]", joint, one.address, other),
               "set another one at the driver", "", Cause::kExists},
              "address");
}

/// Returns the map's file: beside the cell file, or else of those that came with the programs,
/// installed or in the checkout. Throws InputError naming where it is not.
std::filesystem::path map_file(const CellSettings& cell, const std::string& name) {
  namespace fs = std::filesystem;
  fs::path beside = cell.file.parent_path() / name;
  if (fs::exists(beside)) return beside;
  std::error_code unknown;
  const fs::path programs = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  for (fs::path folder = programs; folder.has_relative_path(); folder = folder.parent_path())
    for (const char* place : {"share/planar-servo/calib/modbus", "calib/modbus"})
      if (fs::exists(folder / place / name)) return folder / place / name;
  throw InputError(
      {fmt::format("there is no map of registers {}, nor one of this name in calib/modbus where "
                   "the programs of {} were installed or built",
                   beside.string(), programs.string()),
       "write it by doc/modbus.md, or name it with its folder", "", Cause::kMissing});
}

/// Checks that a map can do what a joint of the cell needs.
void require_map(const CellSettings& cell, std::size_t joint, const ModbusMap& map) {
  const MotorDrive& motor = cell.transmission.drives[joint];
  if (const auto why = map.misfit(limits_of(cell)[joint], motor.pulses_per_motor_turn))
    throw InputError(why->at(fmt::format("drives[{}]", joint)));
  const bool is_forward = motor.home == HomeReference::kForwardSwitch;
  if (is_switch(motor.home) && (is_forward ? map.home_forward : map.home_reverse).empty())
    throw InputError(
        {fmt::format("drives[{}]: the map {} has no {}", joint, map.name,
                     is_forward ? "home_forward" : "home_reverse"),
         "add it, if the driver searches switches, or name home: {reference: taught} or sight", "",
         Cause::kMissing});
}

ModbusLine line_of(const CellSettings& cell) {
  ModbusLine line = details_of<ModbusDetails>(cell.drives[0]).line;
  for (std::size_t i = 0; i < 3; ++i) {
    line.addresses[i] = details_of<ModbusDetails>(cell.drives[i]).address;
    line.counts_per_turn[i] = cell.transmission.drives[i].pulses_per_motor_turn;
  }
  return line;
}

std::string name_of(const ModbusLine& line) {
  return fmt::format("{} on {}", line.map.name, line.port);
}

}  // namespace

std::string ModbusKind::new_keys(std::size_t joint, double mark_deg) const {
  return fmt::format(
             R"(    port: /dev/serial/by-id/ADAPTER  # the RS-485 adapter of all joints
    baud: 115200                   # its speed, and the drivers'
    parity: none                   # none, even, odd
    address: {:<21} # of this joint's driver
    registers: leadshine-rs.yaml   # map of its registers: doc/modbus.md
)",
             joint + 1) +
         new_home(mark_deg);
}

void ModbusKind::read(Fields& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<ModbusDetails>();
  ModbusLine& line = details->line;
  drive.text("port", line.port);
  drive.whole_number("baud", line.baud, 1200, 1000000);
  drive.choice("parity", line.parity, kParities);
  if (drive.given("stop_bits", false)) drive.whole_number("stop_bits", line.stop_bits, 1, 2);
  if (drive.given("answer_ms", false))
    drive.number("answer_ms", line.answer_s, kMillisecond,
                 Range::from_to(kLeastAnswer_ms, kMostAnswer_ms));
  drive.whole_number("address", details->address, kLowestAddress, kHighestAddress);
  drive.text("registers", details->registers);
  try {
    map_file(cell, details->registers);
  } catch (const InputError& missing) {
    drive.check(false, missing.refusal(), "registers");
  }
  cell.drives[joint].details = details;
  list_home(drive, cell, joint);
  for (std::size_t i = 0; i < joint; ++i)
    if (cell.drives[i].kind == this) check_line(drive, cell, joint, i);
}

void ModbusKind::complete(CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<ModbusDetails>(details_of<ModbusDetails>(cell.drives[joint]));
  details->line.map = read_modbus_map(map_file(cell, details->registers));
  require_map(cell, joint, details->line.map);
  cell.drives[joint].details = details;
}

std::shared_ptr<DriveGroup> ModbusKind::open(const CellSettings& cell) const {
  const ModbusLine line = line_of(cell);
  return std::make_shared<LinkedDrives>(
      name_of(line), limits_of(cell), [line] { return std::make_unique<ModbusLink>(line); },
      in_position_counts(cell));
}

std::vector<Finding> ModbusKind::examine(const CellSettings& cell) const {
  const ModbusLine line = line_of(cell);
  const auto judge = [&](ModbusLink& link, const MachineState& state) -> Finding {
    constexpr int kTelegrams = 100;
    while (link.errors().telegrams < kTelegrams) link.read();
    const LineErrors& errors = link.errors();
    if (errors.all() == 0)
      return well(
          fmt::format("{}: all three answer each of {} telegrams", name_of(line), errors.telegrams),
          state,
          line.map.values_of(RegisterValue::What::kAcceleration).empty()
              ? "`move` writes no acceleration, so that joints leave the straight way: see "
                "doc/modbus.md"
              : "");
    const Refusal refusal = errors.refusal();
    return {{name_of(line) + ": " + refusal.fault, refusal.remedy, kDrives, refusal.cause},
            Finding::Verdict::kDoubtful};
  };
  return examine_link<ModbusLink>(line, "", "look it up in the driver's manual",
                                  "see doc/modbus.md", judge);
}

namespace {

/// Those that turn: in the others G20 and G21 change what a number is, and F is along a way in mm.
constexpr Named<char> kLinuxcncAxes[] = {{'A', "A"}, {'B', "B"}, {'C', "C"}};
constexpr int kMostJoint = 15, kHighestPort = 65535;

struct LinuxcncDetails final : DeviceDetails {
  LinuxcncHost host;
  LinuxcncJoint joint;
};

LinuxcncHost host_of(const CellSettings& cell) {
  LinuxcncHost host = details_of<LinuxcncDetails>(cell.drives[0]).host;
  const Eigen::Vector3d pulses_per_rad = Transmission(cell.transmission).pulses_per_rad();
  const auto limits = limits_of(cell);
  for (std::size_t i = 0; i < 3; ++i) {
    host.joints[i] = details_of<LinuxcncDetails>(cell.drives[i]).joint;
    host.joints[i].counts_per_deg = std::abs(pulses_per_rad[i]) * kDegree;
    host.joints[i].rated = limits[i];
    host.joints[i].has_switch = is_switch(cell.transmission.drives[i].home);
  }
  return host;
}

std::string name_of(const LinuxcncHost& host) {
  return fmt::format("LinuxCNC at {}:{}", host.host, host.port);
}

}  // namespace

std::string LinuxcncKind::new_keys(std::size_t joint, double mark_deg) const {
  return fmt::format(
             R"(    host: 127.0.0.1                # where linuxcncrsh listens
    axis: {:<24} # the letter of LinuxCNC's axis that turns this joint
    joint: {:<23} # its number, as in [JOINT_{}]
)",
             kLinuxcncAxes[joint].name, joint, joint) +
         new_home(mark_deg);
}

void LinuxcncKind::read(Fields& drive, CellSettings& cell, std::size_t joint) const {
  auto details = std::make_shared<LinuxcncDetails>();
  LinuxcncHost& host = details->host;
  drive.text("host", host.host);
  if (drive.given("port", false)) drive.whole_number("port", host.port, 1, kHighestPort);
  if (drive.given("password", false)) drive.text("password", host.password);
  if (drive.given("enable_password", false)) drive.text("enable_password", host.enable_password);
  drive.choice("axis", details->joint.axis, kLinuxcncAxes);
  drive.whole_number("joint", details->joint.number, 0, kMostJoint);
  cell.drives[joint].details = details;
  list_home(drive, cell, joint);
  for (std::size_t i = 0; i < joint; ++i) {
    if (cell.drives[i].kind != this) continue;
    const LinuxcncDetails& other = details_of<LinuxcncDetails>(cell.drives[i]);
    check_alike(drive, joint, i,
                {{"host", other.host.host == host.host},
                 {"port", other.host.port == host.port},
                 {"password", other.host.password == host.password},
                 {"enable_password", other.host.enable_password == host.enable_password}},
                "the three joints are those of one machine");
    drive.check(
        other.joint.axis != details->joint.axis && other.joint.number != details->joint.number,
        {fmt::format("drives[{}] has the axis or joint of drives[{}]", joint, i),
         "each needs its own", "", Cause::kExists});
  }
}

std::shared_ptr<DriveGroup> LinuxcncKind::open(const CellSettings& cell) const {
  const LinuxcncHost host = host_of(cell);
  return std::make_shared<LinkedDrives>(
      name_of(host), limits_of(cell), [host] { return std::make_unique<LinuxcncLink>(host); },
      kInPosition_counts);
}

std::vector<Finding> LinuxcncKind::examine(const CellSettings& cell) const {
  const LinuxcncHost host = host_of(cell);
  const auto judge = [&](const LinuxcncLink& link, const MachineState& state) {
    return well(name_of(host) + (link.unchecked().empty() ? ", with the cell's settings" : ""),
                state, link.unchecked());
  };
  return examine_link<LinuxcncLink>(host, "", "look at LinuxCNC's own messages",
                                    "see doc/linuxcnc.md", judge);
}

}  // namespace planar
