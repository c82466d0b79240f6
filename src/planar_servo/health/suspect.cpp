#include "planar_servo/health/suspect.h"

#include <fmt/format.h>

#include "planar_servo/core/plane_geometry.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kPercent = 0.01;
constexpr char kDegrees[] = "deg", kMillimetres[] = "mm", kTurns[] = "turns per turn commanded";

bool is_gear(const Suspect& suspect) {
  return suspect.numbers.front() >= kGearOff && suspect.numbers.front() < kLinkOff;
}

bool is_link(const Suspect& suspect) {
  return suspect.numbers.front() >= kLinkOff && suspect.numbers.front() < kLampOff;
}

/// Returns the size in the suspect's unit: the number, the length of two, or where there are more,
/// what they displace.
double size_of(const Suspect& suspect, const Numbers& off, double cost_m) {
  const double first = off[suspect.numbers[0]];
  if (is_gear(suspect)) return 1.0 + first;
  if (suspect.numbers.size() == 2)
    return std::hypot(first, off[suspect.numbers[1]]) / suspect.unit_size;
  if (suspect.numbers.size() > 2) return cost_m / suspect.unit_size;
  return (suspect.unit == kDegrees ? wrap_angle(first) : first) / suspect.unit_size;
}

}  // namespace

const std::vector<Suspect>& suspects() {
  static const std::vector<Suspect> all{
      {Cause::kCameraShifted, {kShiftOff, kShiftOff + 1}, kMillimetres, kMillimetre},
      {Cause::kCameraTurned, {kTurnOff}, kDegrees, kDegree},
      {Cause::kCameraCloser, {kGrowthOff}, "%", kPercent},
      {Cause::kCameraTilted,
       {kTiltOff, kTiltOff + 1, kShiftOff, kShiftOff + 1},
       kMillimetres,
       kMillimetre},
      {Cause::kLamp1Moved, {kLampOff, kLampOff + 1}, kMillimetres, kMillimetre},
      {Cause::kLamp2Moved, {kLampOff + 2, kLampOff + 3}, kMillimetres, kMillimetre},
      {Cause::kZero1, {kZeroOff}, kDegrees, kDegree},
      {Cause::kZero2, {kZeroOff + 1}, kDegrees, kDegree},
      {Cause::kZero3, {kZeroOff + 2}, kDegrees, kDegree},
      {Cause::kHome, {kZeroOff, kZeroOff + 1, kZeroOff + 2}, kMillimetres, kMillimetre},
      {Cause::kGear1, {kGearOff}, kTurns, 1.0},
      {Cause::kGear2, {kGearOff + 1}, kTurns, 1.0},
      {Cause::kGear3, {kGearOff + 2}, kTurns, 1.0},
      {Cause::kLink1, {kLinkOff}, kMillimetres, kMillimetre},
      {Cause::kLink2, {kLinkOff + 1}, kMillimetres, kMillimetre}};
  return all;
}

HealthFinding finding_of(const Suspect& suspect, const CellModel& as_filed, const Numbers& off,
                         double cost_m) {
  HealthFinding finding{suspect.cause, size_of(suspect, off, cost_m), suspect.unit, cost_m,
                        words(suspect.cause)};
  if (is_gear(suspect)) {
    finding.what += fmt::format(": it turns {:.4f} times as far as commanded", finding.size);
  } else if (is_link(suspect)) {
    const double filed_mm = as_filed.links_m[suspect.numbers[0] - kLinkOff] / kMillimetre;
    finding.what += fmt::format(": {:.2f} mm, not {:.2f} mm", filed_mm + finding.size, filed_mm);
  } else if (suspect.numbers.size() > 2) {
    finding.what +=
        fmt::format("; the tool is seen up to {:.3g} mm from where it was", cost_m / kMillimetre);
  } else {
    finding.what += fmt::format(" by {:.3g} {}", finding.size, finding.unit);
  }
  return finding;
}

}  // namespace planar
