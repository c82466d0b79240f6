#include "planar_servo/report/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "planar_servo/core/text.h"

namespace planar {
namespace {

constexpr double kRoom = 0.05;        // at each end, as a share of the range
constexpr double kRounding = 1e-9;    // of a step
constexpr std::size_t kFewTicks = 2;  // do not show that a scale is one of decades

}  // namespace

Axis axis_over(const std::string& label, const std::vector<double>& values) {
  if (values.empty()) throw std::invalid_argument("an axis needs at least one value");
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double size = std::max(std::abs(*least), std::abs(*most));
  const double range = *most - *least;
  const double room = range > kRounding * size ? kRoom * range : size > 0.0 ? size : 1.0;
  return {label, *least - room, *most + room};
}

Axis decades_over(const std::string& label, const std::vector<double>& values) {
  constexpr double kRatioOfRoom = 1.25;
  std::vector<double> positive;
  std::copy_if(values.begin(), values.end(), std::back_inserter(positive),
               [](double value) { return value > 0.0; });
  if (positive.empty()) throw std::invalid_argument("an axis of decades needs a value above zero");
  const auto [least, most] = std::minmax_element(positive.begin(), positive.end());
  return {label, *least / kRatioOfRoom, *most * kRatioOfRoom, Spacing::kDecades};
}

double Axis::share(double value) const {
  if (spacing == Spacing::kEven) return (value - from) / (to - from);
  return std::log(std::max(value, lowest()) / from) / std::log(to / from);
}

Ticks Axis::ticks(int most) const {
  if (spacing == Spacing::kEven) return round_ticks(lowest(), highest(), most);
  Ticks ticks = decade_ticks(lowest(), highest());
  return ticks.values.size() < kFewTicks ? round_ticks(lowest(), highest(), most) : ticks;
}

std::string Ticks::text(double value) const {
  const double decade = std::floor(std::log10(step) + kRounding);
  if (decade < -6.0 || decade > 5.0) return fmt::format("{:g}", value);
  return fixed(value, decade < 0.0 ? static_cast<int>(-decade) : 0);
}

Ticks round_ticks(double lowest, double highest, int most) {
  if (!(lowest < highest)) throw std::invalid_argument("ticks need a range that is not empty");
  Ticks ticks;
  double decade = std::pow(10.0, std::floor(std::log10((highest - lowest) / most)));
  for (const double digits : {1.0, 2.0, 5.0, 10.0, 20.0}) {
    ticks.step = digits * decade;
    const double first = std::ceil(lowest / ticks.step - kRounding);
    const double last = std::floor(highest / ticks.step + kRounding);
    if (last - first >= most) continue;
    for (double i = first; i <= last; ++i) ticks.values.push_back(i * ticks.step);
    break;
  }
  return ticks;
}

Ticks decade_ticks(double lowest, double highest) {
  constexpr double kFewDecades = 300.0;  // the ratio up to which ticks within decades have room
  Ticks ticks;
  ticks.step = 0.0;
  for (double decade = std::pow(10.0, std::floor(std::log10(lowest))); decade <= highest;
       decade *= 10.0)
    for (const double digits : {1.0, 2.0, 5.0})
      if (const double value = digits * decade; value >= lowest && value <= highest)
        if (highest / lowest < kFewDecades || digits == 1.0) ticks.values.push_back(value);
  return ticks;
}

double round_length(double most) {
  const double decade = std::pow(10.0, std::floor(std::log10(most)));
  const double digits = most / decade;
  return decade * (digits >= 5.0 ? 5.0 : digits >= 2.0 ? 2.0 : 1.0);
}

}  // namespace planar
