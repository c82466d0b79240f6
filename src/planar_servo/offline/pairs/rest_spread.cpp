#include "planar_servo/offline/pairs/rest_spread.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <map>

#include "planar_servo/core/numerics/chance.h"
#include "planar_servo/core/units.h"

namespace planar {

RestSpread rest_spread(const std::vector<TrackerRow>& readings, const TrackerSettings& tracker) {
  std::map<std::string, std::vector<Eigen::Vector3d>> places;
  for (const TrackerRow& row : readings) places[row.id].push_back(row.p_L);
  double squares = 0.0, variances = 0.0;
  RestSpread spread;
  for (const auto& [id, at] : places) {
    if (at.size() < 2) continue;
    Eigen::Vector3d mean(0.0, 0.0, 0.0);
    for (const Eigen::Vector3d& p : at) mean += p / static_cast<double>(at.size());
    for (const Eigen::Vector3d& p : at) squares += (p - mean).squaredNorm();
    const int free = 3 * (static_cast<int>(at.size()) - 1);
    spread.freedom += free;
    variances += free * std::pow(tracker.sigma_at(mean.norm()), 2);
  }
  if (spread.freedom == 0) return spread;
  spread.rms = std::sqrt(squares / spread.freedom);
  spread.stated = std::sqrt(variances / spread.freedom);
  return spread;
}

bool is_shaking(const RestSpread& spread) {
  // A smaller excess changes what follows by less than the deviation itself is known.
  constexpr double kShaking = 1.5;
  if (spread.freedom == 0 || spread.rms <= kShaking * spread.stated) return false;
  const double square = spread.freedom * std::pow(spread.rms / spread.stated, 2);
  return chi_square_tail(square, spread.freedom) < kFalseAlarm;
}

std::string doubt_of_rest(const RestSpread& spread) {
  return fmt::format(
      "tracker: its readings of a place at rest scatter by {:.4f} mm, where {:.4f} mm is stated, "
      "and "
      "are taken for as uncertain as they scatter; find what shakes the reflector or the tracker, "
      "or correct tracker.sigma_mm in the cell file",
      spread.rms / kMillimetre, spread.stated / kMillimetre);
}

TrackerSettings with_found_scatter(TrackerSettings tracker, const RestSpread& spread) {
  tracker.sigma_m *= spread.rms / spread.stated;
  tracker.sigma_m_per_m *= spread.rms / spread.stated;
  return tracker;
}

}  // namespace planar
