#include "planar_servo/hardware/drives/grbl_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <type_traits>

#include "planar_servo/base/core/text.h"

namespace planar::grbl {
namespace {

constexpr std::size_t kLongestGarbage = 40;
constexpr double kSlowestPerMinute_mm = 1.0;
constexpr int kPlaces = 3;  ///< of every length on the line

constexpr Named<State> kStates[] = {{State::kIdle, "Idle"},   {State::kRun, "Run"},
                                    {State::kHold, "Hold"},   {State::kJog, "Jog"},
                                    {State::kAlarm, "Alarm"}, {State::kDoor, "Door"},
                                    {State::kCheck, "Check"}, {State::kHome, "Home"},
                                    {State::kSleep, "Sleep"}, {State::kToolChange, "Tool"}};

constexpr Named<State> kStateFaults[] = {{State::kHold, "it is on hold"},
                                         {State::kAlarm, "it is locked by an alarm"},
                                         {State::kDoor, "its safety door is open"},
                                         {State::kCheck, "it only checks commands ($C)"},
                                         {State::kSleep, "it is asleep"},
                                         {State::kToolChange, "it waits for a tool change"},
                                         {State::kRun, "it runs somebody else's program"}};

constexpr Named<int> kGrblAlarms[] = {
    {1, "a limit switch was hit"},
    {2, "a target lay beyond the soft limits"},
    {3, "it was reset while it moved"},
    {4, "the probe was not in its initial state"},
    {5, "the probe found nothing"},
    {6, "the search for the home switches was interrupted by a reset"},
    {7, "the safety door was opened during the search for the home switches"},
    {8, "a home switch stays pressed after pulling off ($27)"},
    {9, "no home switch was found within its travel ($130 to $132)"},
    {10, "the emergency stop is pressed"},
    {11, "it must be homed first"},
    {12, "a limit switch is pressed"},
    {13, "the probe is protected"},
    {14, "the spindle did not come up to speed"},
    {15, "the second motor of an axis did not find its home switch"},
    {16, "its power-on self-test failed"},
    {17, "a motor driver reports a fault"},
    {18, "its homing settings contradict each other"}};

constexpr Named<int> kGrblErrors[] = {
    {1, "a letter of the command is missing"},
    {2, "a number is malformed"},
    {3, "it does not know the command"},
    {4, "a value is negative"},
    {5, "homing is switched off ($22)"},
    {6, "a step pulse is too short ($0)"},
    {7, "its stored settings were lost and are its maker's defaults"},
    {8, "it is not idle"},
    {9, "it is locked by an alarm"},
    {10, "soft limits need homing ($22)"},
    {11, "the line is too long"},
    {12, "the step rate is too high"},
    {13, "the safety door is open"},
    {14, "a stored line is too long"},
    {15, "the target lies beyond the soft limits ($130 to $132)"},
    {16, "the jog command is malformed"},
    {17, "laser mode needs a spindle"},
    {18, "the emergency stop or the reset input is pressed"},
    {20, "it does not support the command"},
    {21, "two commands exclude each other"},
    {22, "the feed rate is missing"},
    {23, "a number must be whole"},
    {24, "two commands use the same word"},
    {25, "a word is repeated"},
    {26, "the words of the axes are missing"},
    {27, "the line number is invalid"},
    {28, "a value is missing"},
    {33, "the target is invalid"},
    {38, "a tool number is too large"},
    {45, "a limit switch is pressed"},
    {46, "it must be homed first"}};

/// Takes a number off the front of a text. Empty, and the text unchanged, when there is none.
template <typename Number>
std::optional<Number> take_number(std::string_view& text) {
  Number number{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{}) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(number)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

Garbage garbage(std::string_view text) {
  const bool report = !text.empty() && (text.front() == '<' || text.back() == '>');
  Garbage found{std::string(text.substr(0, kLongestGarbage)), report};
  std::replace_if(
      found.text.begin(), found.text.end(), [](char c) { return c < ' ' || c > '~'; }, '.');
  return found;
}

/// Parses a whole number that is all of `text`.
template <typename Numbered>
Line numbered(std::string_view text, std::string_view line) {
  const auto number = take_number<int>(text);
  if (!number || !text.empty()) return garbage(line);
  return Numbered{*number};
}

std::optional<std::array<double, 3>> parse_position(std::string_view text) {
  std::array<double, 3> position_mm{};
  for (std::size_t i = 0; i < position_mm.size(); ++i) {
    if (i > 0 && !take_prefix(text, ",")) return std::nullopt;
    const auto number = take_number<double>(text);
    if (!number) return std::nullopt;
    position_mm[i] = *number;
  }
  if (!text.empty() && text.front() != ',') return std::nullopt;
  return position_mm;
}

/// `word` is the state with its substate, such as "Hold:1" while a board brakes to a hold.
bool motors_turn(State state, std::string_view word) {
  return state == State::kJog || state == State::kRun || state == State::kHome ||
         word == "Hold:1" || word == "Door:2" || word == "Door:3";
}

/// Parses "Idle|MPos:1.000,0.500,0.200|FS:0,0|Pn:X".
Line parse_report(std::string_view text, std::string_view line) {
  Report report;
  const std::string_view word = text.substr(0, text.find('|'));
  const auto state = value_named(kStates, word.substr(0, word.find(':')));
  if (!state) return garbage(line);
  report.state = *state;
  report.turns = motors_turn(*state, word);
  text.remove_prefix(word.size());
  while (take_prefix(text, "|")) {
    std::string_view field = text.substr(0, text.find('|'));
    text.remove_prefix(field.size());
    if (take_prefix(field, "Pn:")) report.pins = field;
    if (take_prefix(field, "FS:") || take_prefix(field, "F:"))
      report.speed_mm_min = take_number<double>(field).value_or(0.0);
    if (!take_prefix(field, "MPos:")) continue;
    report.position_mm = parse_position(field);
    if (!report.position_mm) return garbage(line);
  }
  return report;
}

/// FluidNC's settings of an axis by what follows "axes/x/", with the number that Grbl gives them,
/// or one of its own [FluidNC wiki, Config items; Commands and settings].
struct FluidncSetting {
  const char* name;
  int number;  ///< of axis X; those of Y and Z follow
};
constexpr int kFluidncCycle = 2200, kFluidncPositive = 2300, kFluidnc = 2400;
constexpr FluidncSetting kFluidncAxis[] = {{"steps_per_mm", 100},
                                           {"max_rate_mm_per_min", 110},
                                           {"acceleration_mm_per_sec2", 120},
                                           {"homing/cycle", kFluidncCycle},
                                           {"homing/positive_direction", kFluidncPositive}};
constexpr char kFluidncIdle[] = "/stepping/idle_ms";
constexpr char kFluidncAxes[] = "xyz";

std::string fluidnc_path(const FluidncSetting& setting, int axis) {
  return fmt::format("/axes/{}/{}", kFluidncAxes[axis], setting.name);
}

/// Returns the path of a setting that Grbl numbers so; the number where FluidNC has it, too.
std::string fluidnc_path(int number) {
  if (number == 1) return kFluidncIdle;
  for (const FluidncSetting& setting : kFluidncAxis)
    if (number >= setting.number && number < setting.number + 3)
      return fluidnc_path(setting, number - setting.number);
  return std::to_string(number);
}

/// Parses "/axes/x/steps_per_mm=250.000", the rest of a line of FluidNC.
Line parse_path(std::string_view text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string_view::npos) return Remark{};
  const std::string_view path = text.substr(0, sign);
  std::string_view value = text.substr(sign + 1);
  std::optional<double> number = take_number<double>(value);
  if (value == "true" || value == "false") number = value == "true" ? 1.0 : 0.0;
  if (!number) return Remark{};
  if (path == kFluidncIdle) return StoredSetting{1, *number};
  for (const FluidncSetting& setting : kFluidncAxis)
    for (int axis = 0; axis < 3; ++axis)
      if (path == fluidnc_path(setting, axis)) return StoredSetting{setting.number + axis, *number};
  return Remark{};
}

Line parse_setting(std::string_view text, std::string_view line) {
  if (!text.empty() && text.front() == '/') return parse_path(text);
  const auto number = take_number<int>(text);
  if (!number || !take_prefix(text, "=")) return garbage(line);
  const auto value = take_number<double>(text);
  if (!value || !text.empty()) return Remark{};
  return StoredSetting{*number, *value};
}

/// Parses "Grbl 1.1h ['$' for help]" and "GrblHAL 1.1f [...]".
Line parse_banner(std::string_view line) {
  const std::size_t gap = line.find(' ');
  if (gap == std::string_view::npos) return garbage(line);
  std::string_view version = line.substr(gap + 1);
  const auto number = take_number<double>(version);
  if (!number) return garbage(line);
  constexpr std::string_view kFluidncName = "[FluidNC ";
  if (const std::size_t name = line.find(kFluidncName); name != std::string_view::npos) {
    const std::string_view said = line.substr(name + 1);
    return Banner{std::string(said.substr(0, said.find(' ', kFluidncName.size()))), *number};
  }
  return Banner{std::string(line.substr(0, line.find(' ', gap + 1))), *number};
}

template <std::size_t N>
std::string words_in(const Named<int> (&table)[N], const char* what, int number) {
  for (const auto& [known, words] : table)
    if (known == number) return fmt::format("{} {}: {}", what, number, words);
  return fmt::format("{} {}, which its maker's list explains", what, number);
}

/// Firmware that is not supported, by a part of what it says at its start, or asked by $I or M115.
constexpr Named<std::string_view> kForeign[] = {
    {"Grbl_ESP32", "Grbl_ESP32 (its development has ended)"},
    {"Grbl 1.3a", "Grbl_ESP32 (its development has ended)"},
    {"Grbl 0.", "a Grbl before 1.1 (it cannot jog)"},
    {"Marlin", "Marlin"},
    {"Smoothie", "Smoothieware"},
    {"Repetier", "Repetier"},
    {"RepRapFirmware", "RepRapFirmware"},
    {"Klipper", "Klipper"},
    {"TinyG", "TinyG"},
    {"g2core", "g2core"},
    {"\"fb\":", "TinyG or g2core"},
    {"[fb]", "TinyG or g2core"}};
constexpr double kSupportedVersion = 1.1;

constexpr double kThousandths = 1000.0;
constexpr double kAllowedDifference = 1e-3;

constexpr int kStepIdleDelay = 1;
constexpr int kReportMask = 10;
constexpr int kReportInches = 13;
constexpr int kHomingEnabled = 22;
constexpr int kHomingDirections = 23;
constexpr int kPulsesPerMm = 100;
constexpr int kMaxRate = 110;
constexpr int kAcceleration = 120;
constexpr double kAlwaysOn = 255.0;
constexpr double kMostBits = 65535.0;

bool whole(double value) {
  return std::abs(value - std::round(value)) < 1e-9 * std::max(1.0, std::abs(value));
}

/// Collects what a board's settings should be instead.
class Comparison {
 public:
  explicit Comparison(const Settings& settings) : settings_(settings) {}

  /// Returns the bits of a setting; none when the board does not have it.
  unsigned bits(int number) const {
    const auto found = settings_.find(number);
    if (found == settings_.end()) return 0U;
    return static_cast<unsigned>(std::lround(std::clamp(found->second, 0.0, kMostBits)));
  }

  void require(int number, double wanted, const char* why) {
    const auto found = settings_.find(number);
    if (found != settings_.end() &&
        std::abs(found->second - wanted) <= kAllowedDifference * std::abs(wanted))
      return;
    const std::string has =
        found == settings_.end() ? "missing" : fmt::format("{:g}", found->second);
    faults_.push_back(fmt::format("${} is {} ({})", number, has, why));
    command(number, std::round(wanted * 1e3) * 1e-3);
  }

  void command(int number, double value) {
    if (settings_.count(kFluidnc) == 0)
      return commands_.push_back(fmt::format("${}={:g}", number, value));
    if (number == kHomingDirections) {
      for (int axis = 0; axis < 3; ++axis)
        commands_.push_back(
            fmt::format("${}={}", fluidnc_path(kFluidncPositive + axis),
                        (static_cast<int>(value) >> axis & 1) != 0 ? "false" : "true"));
      return;
    }
    const int first = number == kHomingEnabled ? kFluidncCycle : number;
    commands_.push_back(fmt::format("${}={:g}", fluidnc_path(first), value));
  }

  std::optional<Refusal> refusal() const {
    if (faults_.empty()) return std::nullopt;
    return Refusal{fmt::format("its settings do not match the cell: {}", fmt::join(faults_, ", ")),
                   fmt::format("send it {} with a terminal program, or correct the cell file",
                               fmt::join(commands_, " and ")),
                   "", Cause::kContradiction};
  }

 private:
  const Settings& settings_;
  std::vector<std::string> faults_, commands_;
};

void compare_axis(const GrblAxis& axis, Comparison& board) {
  const auto of_axis = [&](int first) { return first + static_cast<int>(axis.index()); };
  board.require(of_axis(kPulsesPerMm), axis.pulses_per_mm, "the cell's pulses_per_mm differs");
  board.require(of_axis(kMaxRate), axis.speed_pulses_s / axis.pulses_per_mm * kMinute_s,
                "the cell's max_speed_deg_s differs, in mm/min");
  board.require(of_axis(kAcceleration), axis.acceleration_pulses_s2 / axis.pulses_per_mm,
                "the cell's max_acceleration_deg_s2 differs, in mm/s^2");
}

void compare_homing(const std::array<GrblAxis, 3>& axes, Comparison& board) {
  if (!is_switch(axes[0].home)) return;
  if ((board.bits(kHomingEnabled) & 1U) == 0)
    board.require(kHomingEnabled, board.bits(kHomingEnabled) | 1U, "the cell has home switches");
  unsigned directions = board.bits(kHomingDirections);
  for (const GrblAxis& axis : axes) {
    const unsigned bit = 1U << axis.index();
    directions = axis.home == HomeReference::kReverseSwitch ? directions | bit : directions & ~bit;
  }
  if (directions != board.bits(kHomingDirections))
    board.require(kHomingDirections, directions, "the cell's home switches lie elsewhere");
}

}  // namespace

Line parse_line(std::string_view text) {
  const std::string_view line = text;
  if (text == "ok") return Accepted{};
  if (take_prefix(text, "error:")) return numbered<Rejected>(text, line);
  if (take_prefix(text, "ALARM:")) return numbered<Alarm>(text, line);
  if (take_prefix(text, "$")) return parse_setting(text, line);
  if (take_prefix(text, "Grbl")) return parse_banner(line);
  if (text.empty() || text.front() == '>') return Remark{};
  if (text.front() == '[' && text.back() == ']') return Remark{};
  if (text.front() == '<' && text.back() == '>')
    return parse_report(text.substr(1, text.size() - 2), line);
  return garbage(line);
}

std::optional<Refusal> foreign_firmware(std::string_view said) {
  for (const auto& [sign, name] : kForeign)
    if (said.find(sign) != std::string_view::npos)
      return Refusal{fmt::format("has {}, which is not supported", name),
                     "flash Grbl 1.1 (AVR processors) or grblHAL (ESP32 and most others), or use "
                     "another board; see doc/drives.md",
                     "", Cause::kForeign};
  return std::nullopt;
}

bool is_fluidnc(std::string_view said) {
  return said.find("FluidNC") != std::string_view::npos;
}

std::vector<std::string> fluidnc_questions() {
  std::vector<std::string> questions{fmt::format("${}", kFluidncIdle), "$10", "$13"};
  for (const FluidncSetting& setting : kFluidncAxis)
    for (int axis = 0; axis < 3; ++axis) questions.push_back("$" + fluidnc_path(setting, axis));
  return questions;
}

void fold_fluidnc(Settings& settings) {
  settings[kFluidnc] = 1.0;
  double enabled = 0.0, directions = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (settings[kFluidncCycle + axis] > 0.0) enabled = 1.0;
    if (settings[kFluidncPositive + axis] == 0.0) directions += 1 << axis;
  }
  settings[kHomingEnabled] = enabled;
  settings[kHomingDirections] = directions;
}

bool is_supported(const Banner& version) {
  return version.number == kSupportedVersion;
}

std::string alarm_words(int number) {
  return words_in(kGrblAlarms, "alarm", number);
}

bool is_by_hand(State state) {
  return state == State::kHold || state == State::kDoor || state == State::kRun;
}

bool is_by_hand(int alarm) {
  return alarm == 3 || alarm == 6 || alarm == 7 || alarm == 10;  // resets, the door, the stop
}

std::string error_words(int number) {
  return words_in(kGrblErrors, "error", number);
}

std::string state_words(State state) {
  for (const auto& [fault, words] : kStateFaults)
    if (fault == state) return words;
  return "";
}

std::string jog_line(const std::array<double, 3>& target_mm, double speed_mm_s) {
  return fmt::format("$J=G21G53G90X{}Y{}Z{}F{}", fixed(target_mm[0], kPlaces),
                     fixed(target_mm[1], kPlaces), fixed(target_mm[2], kPlaces),
                     fixed(std::max(speed_mm_s * kMinute_s, kSlowestPerMinute_mm), kPlaces));
}

bool keeps_pulses(double pulses_per_mm) {
  return whole(kThousandths * pulses_per_mm) && whole(kThousandths / pulses_per_mm);
}

std::optional<Refusal> unfitness(const Settings& settings, const GrblSettings& cell) {
  Comparison board(settings);
  board.require(kStepIdleDelay, kAlwaysOn, "its motors would be switched off at rest");
  if ((board.bits(kReportMask) & 1U) == 0)
    board.require(kReportMask, board.bits(kReportMask) | 1U,
                  "it does not report the machine's position");
  if (board.bits(kReportInches) != 0) board.require(kReportInches, 0.0, "it reports inches");
  for (const GrblAxis& axis : cell.axes) compare_axis(axis, board);
  compare_homing(cell.axes, board);
  return board.refusal();
}

}  // namespace planar::grbl
