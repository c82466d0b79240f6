#include "planar_servo/drives/grbl/grbl_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace planar::grbl {
namespace {

constexpr double kOldestVersion = 1.1;
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

/// Gathers what a board's settings should be instead.
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
    commands_.push_back(fmt::format("${}={:g}", number, std::round(wanted * 1e3) * 1e-3));
  }

  std::optional<Refusal> refusal() const {
    if (faults_.empty()) return std::nullopt;
    return Refusal{fmt::format("its settings do not suit the cell: {}", fmt::join(faults_, ", ")),
                   fmt::format("send it {} with a terminal program, or correct the cell file",
                               fmt::join(commands_, " and "))};
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
  if (axes[0].home == HomeReference::kTaught) return;
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

bool keeps_pulses(double pulses_per_mm) {
  return whole(kThousandths * pulses_per_mm) && whole(kThousandths / pulses_per_mm);
}

std::optional<Refusal> unfitness(const Banner& version, const Settings& settings,
                                 const GrblSettings& cell) {
  if (version.number < kOldestVersion)
    return Refusal{version.version + " is too old: it cannot jog",
                   "flash Grbl 1.1 or later, or grblHAL"};
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
