#include "planar_servo/health/light_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace planar {
namespace {

/// One respect in which looks are compared.
struct Respect {
  Cause cause;
  double (*value)(const LampLook&);
  bool counts_above, counts_below;  ///< which way out of the range is a fault
  double least_width;               ///< of a range: what noise does to one look
  const char* format;               ///< of the lamp, the value and its range
  const char* unit;
};

/// The widths are those of noise: two grey levels, a tenth of the usual blur, one per cent of a
/// diameter of 30 px and more.
const Respect kRespects[] = {
    {Cause::kBackground, [](const LampLook& look) { return look.background; }, true, false, 2.0,
     "{}: the background of lamp {} is {:.0f} of 255, was {:.0f} to {:.0f}", "levels"},
    {Cause::kTooBright, [](const LampLook& look) { return look.contrast(); }, true, false, 5.0,
     "{}: lamp {} is {:.0f} levels above its background, was {:.0f} to {:.0f}", "levels"},
    {Cause::kBlurred, [](const LampLook& look) { return look.blur_px; }, true, false, 0.1,
     "{}: the rim of lamp {} is blurred by {:.2f} px, was {:.2f} to {:.2f}", "px"},
    {Cause::kOval, [](const LampLook& look) { return look.axis_ratio; }, false, true, 0.01,
     "{}: the axes of lamp {} are as {:.2f} to 1, were {:.2f} to {:.2f}", ""},
};

/// Returns the mean of a value over the looks that have it; 0 without any.
double mean_of(const std::vector<LampLooks>& looks, std::size_t lamp, const Respect& respect) {
  double sum = 0.0, count = 0.0;
  for (const LampLooks& look : looks) {
    const double value = respect.value(look[lamp]);
    if (!(value > 0.0)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace

std::optional<LookRanges> ranges_of(const std::vector<LampLooks>& looks) {
  if (looks.empty()) return std::nullopt;
  LookRanges ranges;
  constexpr double LampLook::*kFields[] = {&LampLook::level, &LampLook::background,
                                           &LampLook::blur_px, &LampLook::axis_ratio};
  for (std::size_t lamp = 0; lamp < 2; ++lamp)
    for (const auto field : kFields) {
      const auto [least, most] = std::minmax_element(
          looks.begin(), looks.end(),
          [&](const LampLooks& a, const LampLooks& b) { return a[lamp].*field < b[lamp].*field; });
      ranges[lamp].least.*field = (*least)[lamp].*field;
      ranges[lamp].most.*field = (*most)[lamp].*field;
    }
  return ranges;
}

std::optional<HealthFinding> find_light_change(const LookRanges& then,
                                               const std::vector<LampLooks>& now, double cost_m) {
  for (const Respect& respect : kRespects)
    for (std::size_t lamp = 0; lamp < 2; ++lamp) {
      const double value = mean_of(now, lamp, respect);
      const double least = respect.value(then[lamp].least), most = respect.value(then[lamp].most);
      const double width = std::max(respect.least_width, most - least);
      const bool changed = (respect.counts_above && value > most + width) ||
                           (respect.counts_below && value < least - width);
      if (!(value > 0.0) || !changed) continue;
      return HealthFinding{respect.cause, value, respect.unit, cost_m,
                           fmt::format(fmt::runtime(respect.format), words(respect.cause), lamp + 1,
                                       value, least, most)};
    }
  return std::nullopt;
}

}  // namespace planar
