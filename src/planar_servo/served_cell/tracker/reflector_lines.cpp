#include "planar_servo/served_cell/tracker/reflector_lines.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kMostBroken_percent = 90.0;
constexpr double kMostPpm = 10000.0;
constexpr double kMostOffset_s = 1e9;

void require_range(const char* what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw InputError(
      fmt::format("{} is {:g}; a number from {:g} to {:g} is needed", what, value, least, most));
}

std::string number(double value, bool decimal_comma) {
  std::string text = fmt::format("{:.4f}", value);
  if (decimal_comma) text[text.find('.')] = ',';
  return text;
}

}  // namespace

ReflectorLines::ReflectorLines(const ReflectorDialect& dialect, double start_s, std::uint32_t seed)
    : dialect_(dialect), start_s_(start_s), random_(seed) {
  require_range("the offset of the tracker's clock (s)", dialect.clock_offset_s, -kMostOffset_s,
                kMostOffset_s);
  require_range("the rate of the tracker's clock (ppm)", dialect.clock_ppm, -kMostPpm, kMostPpm);
  require_range("the share of broken beams (percent)", dialect.broken_percent, 0.0,
                kMostBroken_percent);
}

std::string ReflectorLines::header() const {
  return joined({"t_s", "x_mm", "y_mm", "z_mm"});
}

std::optional<std::string> ReflectorLines::next(double now_s, const TrackerReading& reading) {
  if (beam_is_broken()) return std::nullopt;
  const double t_s =
      now_s + dialect_.clock_offset_s + 1e-6 * dialect_.clock_ppm * (now_s - start_s_);
  const auto text = [this](double value) { return number(value, dialect_.decimal_comma); };
  return joined({text(t_s), text(reading.p_L.x() / kMillimetre),
                 text(reading.p_L.y() / kMillimetre), text(reading.p_L.z() / kMillimetre)});
}

/// Breaks begin at random, so often that the beam is broken for the stated share of the time.
bool ReflectorLines::beam_is_broken() {
  if (left_broken_ > 0) return --left_broken_ > 0;
  const double share = 0.01 * dialect_.broken_percent;
  const double readings = kBreak_s / kPeriod_s;
  std::bernoulli_distribution breaks(share / (share + readings * (1.0 - share)));
  if (!breaks(random_)) return false;
  left_broken_ = static_cast<int>(std::lround(readings));
  return true;
}

std::string ReflectorLines::joined(const std::array<std::string, 4>& fields) const {
  return fmt::format("{}", fmt::join(fields, dialect_.decimal_comma ? ";" : ","));
}

}  // namespace planar
