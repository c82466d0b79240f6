#include "planar_servo/drives/grbl/grbl_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace planar {
namespace {

constexpr double kFarthestReported_pulses = 1 << 30;
/// So many garbled reports in a row are one too many.
constexpr int kGarbledReports = 3;

/// The share of a speed down to which it has not changed: boards round it.
constexpr double kSameSpeed = 0.98;

bool holds(const std::string& letters, char letter) {
  return letters.find(letter) != std::string::npos;
}

void drop(std::string& letters, char letter) {
  letters.erase(std::remove(letters.begin(), letters.end(), letter), letters.end());
}

}  // namespace

GrblWatch::GrblWatch(const Eigen::Vector3d& pulses_per_mm) : pulses_per_mm_(pulses_per_mm) {}

void GrblWatch::take(const grbl::Report& report) {
  const std::string previous_pins = report_.pins;
  const double speed = report.speed_mm_min, before = report_.speed_mm_min;
  slows_ = report.turns && (speed < kSameSpeed * before || (slows_ && speed <= before));
  report_ = report;
  garbled_reports_ = 0;
  take_pins(previous_pins);
  if (report.position_mm) take_place(*report.position_mm);
}

void GrblWatch::take_pins(const std::string& previous) {
  for (const char axis : {'X', 'Y', 'Z'}) {
    if (report_.pressed(axis) != holds(previous, axis)) continue;
    drop(pressed_, axis);
    if (report_.pressed(axis))
      pressed_ += axis;
    else
      drop(pressed_from_start_, axis);
  }
}

void GrblWatch::take_place(const std::array<double, 3>& position_mm) {
  const Eigen::Vector3d pulses =
      Eigen::Vector3d(position_mm.data()).cwiseProduct(pulses_per_mm_).array().round();
  if (!(pulses.cwiseAbs().maxCoeff() <= kFarthestReported_pulses)) return;
  const AxisPulses place = pulses.cast<int>();
  if (way_.isEmpty()) way_.extend(place);
  const bool believed = on_way(place) || off_way_seen_;
  off_way_seen_ = !on_way(place);
  if (!believed) return;
  here_ = place;
  knows_place_ = true;
}

bool GrblWatch::minds(const grbl::Garbage& garbage) {
  garbled_reports_ = garbage.report ? garbled_reports_ + 1 : kGarbledReports;
  return garbled_reports_ >= kGarbledReports;
}

bool GrblWatch::on_way(const AxisPulses& place) const {
  const AxisPulses one(1, 1, 1);
  return Eigen::AlignedBox3i(way_.min() - one, way_.max() + one).contains(place);
}

std::string GrblWatch::off_way_words() const {
  const AxisPulses lower = way_.min(), upper = way_.max();
  return fmt::format(
      "it is off its way: at X, Y, Z of {}, {}, {} pulses instead of {} to {}, {} to {}, {} to {}",
      here_.x(), here_.y(), here_.z(), lower.x(), upper.x(), lower.y(), upper.y(), lower.z(),
      upper.z());
}

void GrblWatch::forget_way() {
  way_.setEmpty();
  off_way_seen_ = false;
}

bool GrblWatch::newly_pressed(char axis) const {
  return holds(pressed_, axis) && !holds(pressed_from_start_, axis);
}

}  // namespace planar
