#include "planar_servo/trackers/stream/rest_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kWindow_s = 0.5;
constexpr std::size_t kLeastReadings = 5;
/// Noise of the stated size stays below in all but one of a thousand windows of five readings.
constexpr double kScatterOverSigma = 1.5;
constexpr double kLeastBound = 2.0 * kMicrometre;

}  // namespace

void RestWindow::add(const StreamedReading& reading, double arrived_s) {
  window_.push_back({reading, arrived_s});
  while (window_.size() > kLeastReadings && arrived_s - window_[1].arrived_s >= kWindow_s)
    window_.pop_front();
}

bool RestWindow::is_full() const {
  return window_.size() >= kLeastReadings &&
         window_.back().arrived_s - window_.front().arrived_s >= kWindow_s;
}

std::optional<TrackerReading> RestWindow::at_rest() const {
  if (!is_full() || scatter() > bound()) return std::nullopt;
  double t_s = 0.0;
  for (const Arrived& item : window_) t_s += item.reading.t_s.value_or(item.arrived_s);
  return TrackerReading{t_s / static_cast<double>(window_.size()), mean(),
                        static_cast<int>(window_.size())};
}

bool RestWindow::is_frozen() const {
  if (!is_full()) return false;
  double resolution = window_.front().reading.resolution;
  for (const Arrived& item : window_) resolution = std::min(resolution, item.reading.resolution);
  const Eigen::Vector3d& first = window_.front().reading.p_L;
  return resolution <= tracker_.sigma_at(first.norm()) &&
         std::all_of(window_.begin(), window_.end(),
                     [&](const Arrived& item) { return item.reading.p_L == first; });
}

std::string RestWindow::scatter_text() const {
  return fmt::format("{} readings scatter by {:.4f} mm per axis, at rest at most by {:.4f} mm",
                     window_.size(), scatter() / kMillimetre, bound() / kMillimetre);
}

Eigen::Vector3d RestWindow::mean() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Arrived& item : window_) sum += item.reading.p_L;
  return sum / static_cast<double>(window_.size());
}

double RestWindow::scatter() const {
  const Eigen::Vector3d centre = mean();
  double square = 0.0;
  for (const Arrived& item : window_) square += (item.reading.p_L - centre).squaredNorm();
  return std::sqrt(square / (3.0 * static_cast<double>(window_.size())));
}

double RestWindow::bound() const {
  return std::max(kLeastBound, kScatterOverSigma * tracker_.sigma_at(mean().norm()));
}

}  // namespace planar
