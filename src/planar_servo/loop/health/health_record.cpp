#include "planar_servo/loop/health/health_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// What of a lamp is compared between looks.
struct LookFeature {
  HealthCause cause;
  double (*value)(const LampLook&);
  bool counts_above;   ///< out of the range is a fault above it, else below
  double least_width;  ///< of a range: what noise does to one look
  const char* format;  ///< of the lamp, the value and its range
  const char* unit;
};

/// Noise makes the widths: two grey levels, a tenth of the blur, one per cent of 30 px and more.
const LookFeature kLookFeatures[] = {
    {HealthCause::kBackground, [](const LampLook& look) { return look.background; }, true, 2.0,
     "{}: the background of lamp {} is {:.0f} of 255, was {:.0f} to {:.0f}", "levels"},
    {HealthCause::kTooBright, [](const LampLook& look) { return look.contrast(); }, true, 5.0,
     "{}: lamp {} is {:.0f} levels above its background, was {:.0f} to {:.0f}", "levels"},
    {HealthCause::kBlurred, [](const LampLook& look) { return look.blur_px; }, true, 0.1,
     "{}: the rim of lamp {} is blurred by {:.2f} px, was {:.2f} to {:.2f}", "px"},
    {HealthCause::kOval, [](const LampLook& look) { return look.axis_ratio; }, false, 0.01,
     "{}: the axes of lamp {} are as {:.2f} to 1, were {:.2f} to {:.2f}", ""},
};

/// Returns the mean of a value over the looks that have it; 0 without any.
double mean_of(const std::vector<LampLooks>& looks, std::size_t lamp, const LookFeature& feature) {
  double sum = 0.0, count = 0.0;
  for (const LampLooks& look : looks) {
    const double value = feature.value(look[lamp]);
    if (!(value > 0.0)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

double separation(const LampPlaces& lamps_B) {
  return (lamps_B[1] - lamps_B[0]).norm();
}

/// Nothing below half of what a guard without a record allows counts as a stray.
constexpr double kNeverStray_m = 5e-3;
constexpr double kNeverStrayTurn = 1.5 * kDegree;

/// Returns the largest value that is at most three times the 90 % quantile.
double largest_without_strays(const std::vector<double>& values, double never_stray) {
  const double limit = std::max(never_stray, 3.0 * quantile(values, 0.9));
  double largest = 0.0;
  for (const double value : values)
    if (value <= limit) largest = std::max(largest, value);
  return largest;
}

/// Returns the factor that widens the largest of so many values where they are few. One normal
/// value in 17,000 exceeds 1.5 times the largest of 200, but one in 200 exceeds 1.5 times the
/// largest of 22; with this factor it is about one in 17,000 from 12 values on, by simulation.
double few_places(std::size_t count) {
  return std::max(1.0, 0.925 + 15.0 / static_cast<double>(count));
}

/// How far apart two places are for a check: a turn counts by the circle of the lamps.
double apart(const SeenPlace& a, const SeenPlace& b) {
  const double turn = wrap_angle(a.seen.phi - b.seen.phi);
  return (a.seen.p - b.seen.p).norm() + 5.0 * separation(a.place.lamps_B) * std::abs(turn);
}

/// Returns places far apart: each the farthest from those before, the first from the base.
std::vector<std::size_t> spread_places(const std::vector<SeenPlace>& seen) {
  std::vector<std::size_t> chosen;
  std::vector<double> nearest(seen.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < seen.size(); ++i) nearest[i] = seen[i].seen.p.norm();
  while (chosen.size() < std::min(kHealthPlaces, seen.size())) {
    const auto farthest = std::max_element(nearest.begin(), nearest.end());
    const auto next = static_cast<std::size_t>(farthest - nearest.begin());
    if (chosen.empty()) std::fill(nearest.begin(), nearest.end(), 1e9);
    chosen.push_back(next);
    for (std::size_t i = 0; i < seen.size(); ++i)
      nearest[i] = std::min(nearest[i], apart(seen[i], seen[next]));
  }
  return chosen;
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
  for (const LookFeature& feature : kLookFeatures) {
    const auto has_changed = [&](std::size_t lamp) {
      const double value = mean_of(now, lamp, feature);
      const double least = feature.value(then[lamp].least), most = feature.value(then[lamp].most);
      const double width = std::max(feature.least_width, most - least);
      return value > 0.0 && (feature.counts_above ? value > most + width : value < least - width);
    };
    for (std::size_t lamp = 0; lamp < 2; ++lamp) {
      if (!has_changed(lamp)) continue;
      const bool alone = feature.cause == HealthCause::kBlurred && !has_changed(1 - lamp);
      const HealthCause cause = alone ? HealthCause::kUnclearLamp : feature.cause;
      const double value = mean_of(now, lamp, feature);
      return HealthFinding{
          cause, value, feature.unit, cost_m,
          fmt::format(fmt::runtime(feature.format), words(cause), lamp + 1, value,
                      feature.value(then[lamp].least), feature.value(then[lamp].most))};
    }
  }
  return std::nullopt;
}

HealthRecord health_record_of(const std::vector<SeenPlace>& seen) {
  HealthRecord record;
  if (seen.empty()) return record;
  std::vector<double> separations, distances_m, turns;
  for (const SeenPlace& look : seen) {
    separations.push_back(separation(look.place.lamps_B));
    distances_m.push_back((look.seen.p - look.commanded.p).norm());
    turns.push_back(std::abs(wrap_angle(look.seen.phi - look.commanded.phi)));
  }
  const double few = few_places(seen.size());
  record.distance_m = few * largest_without_strays(distances_m, kNeverStray_m);
  record.turn = few * largest_without_strays(turns, kNeverStrayTurn);
  record.separation_m = mean(separations);
  const auto [nearest, farthest] = std::minmax_element(separations.begin(), separations.end());
  record.separation_spread_m =
      few * std::max(record.separation_m - *nearest, *farthest - record.separation_m);
  std::vector<LampLooks> looks;
  for (const SeenPlace& look : seen)
    if (look.looks) looks.push_back(*look.looks);
  record.looks = ranges_of(looks);
  for (const std::size_t i : spread_places(seen)) record.places.push_back(seen[i].place);
  return record;
}

}  // namespace planar
