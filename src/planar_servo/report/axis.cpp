#include "planar_servo/report/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/text.h"
#include "planar_servo/report/html_page.h"

namespace planar {
namespace {

using Rgb = std::array<double, 3>;

/// Viridis at equal distances, from its light end, of which the palest part is left out because it
/// would not show on white, to its dark one.
constexpr Rgb kViridis[] = {{216, 226, 25}, {149, 216, 64}, {85, 198, 103}, {41, 175, 127},
                            {32, 148, 140}, {39, 120, 142}, {51, 92, 141},  {65, 62, 133},
                            {72, 33, 115},  {68, 1, 84}};
constexpr Rgb kGreys[] = {{0, 0, 0}, {255, 255, 255}};

constexpr double kBar = 14.0;  // width of the bar itself
constexpr int kBands = 48;
constexpr int kMostTicks = 6;

constexpr double kRoom = 0.05;        // at each end, as a share of the range
constexpr double kRounding = 1e-9;    // of a step
constexpr std::size_t kFewTicks = 2;  // do not show that a scale is one of decades

}  // namespace

ColorScale::ColorScale(std::string label, const std::vector<double>& values, Steps steps, Hues hues)
    : hues_(hues) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const double value : values) {
    if (!std::isfinite(value) || (steps == Steps::kDecades && value <= 0.0)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  if (least > most) least = most = 1.0;
  if (least == most) {
    least = steps == Steps::kDecades ? 0.5 * least : least - 0.5 * std::abs(least);
    most = steps == Steps::kDecades ? 2.0 * most : most + 0.5 * std::abs(most);
  }
  axis_ = {std::move(label), least, least < most ? most : least + 1.0, steps};
}

double ColorScale::share(double value) const {
  const double share = axis_.share(value);
  return share > 0.0 ? std::min(share, 1.0) : 0.0;
}

std::string ColorScale::color(double value) const {
  const bool is_grey = hues_ == Hues::kGrey;
  const Rgb* colors = is_grey ? kGreys : kViridis;
  const std::size_t last = (is_grey ? std::size(kGreys) : std::size(kViridis)) - 1;
  const double at = share(value) * static_cast<double>(last);
  const std::size_t i = std::min(static_cast<std::size_t>(at), last - 1);
  const double part = at - static_cast<double>(i);
  const auto mixed = [&](std::size_t channel) {
    return static_cast<int>(
        std::lround((1.0 - part) * colors[i][channel] + part * colors[i + 1][channel]));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2));
}

std::string ColorScale::bar_svg(double left, double top, double height) const {
  std::string svg;
  const double band = height / kBands;
  for (int i = 0; i < kBands; ++i) {
    const double share = (i + 0.5) / kBands;
    const double value = axis_.spacing == Spacing::kEven ? from() + share * (to() - from())
                                                         : from() * std::pow(to() / from(), share);
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.2f}\" width=\"{}\" height=\"{:.2f}\" fill=\"{}\"/>\n", left,
        top + height - (i + 1) * band, kBar, band + 0.5, color(value));
  }
  svg += fmt::format(
      "<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\"/>\n", left,
      top, kBar, height);
  const Ticks ticks = axis_.ticks(kMostTicks);
  for (const double value : ticks.values)
    svg +=
        fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", left + kBar + 4.0,
                    top + height * (1.0 - share(value)) + 4.0, ticks.text(value));
  const double x = left + kColorBarWidth - 8.0, y = top + 0.5 * height;
  return svg + fmt::format(
                   "<text class=\"label\" text-anchor=\"middle\" x=\"{0:.1f}\" y=\"{1:.1f}\" "
                   "transform=\"rotate(-90 {0:.1f} {1:.1f})\">{2}</text>\n",
                   x, y, html_escaped(axis_.label));
}

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
