#include "planar_servo/lamps/rim/edge_noise.h"

#include <algorithm>

namespace planar {

double edges_per_independent(std::vector<EdgeResidual> residuals, int reach) {
  constexpr double kLeast = 0.5;
  std::sort(residuals.begin(), residuals.end(),
            [](const EdgeResidual& a, const EdgeResidual& b) { return a.angle < b.angle; });
  const std::size_t n = residuals.size();
  const auto covariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      sum += residuals[i].distance * residuals[(i + lag) % n].distance;
    }
    return sum;
  };
  const double variance = covariance(0);
  if (!(variance > 0.0)) return 1.0;
  double count = 1.0;
  for (int lag = 1; lag <= reach; ++lag) {
    const double weight = 1.0 - lag / (reach + 1.0);
    count += 2.0 * weight * covariance(static_cast<std::size_t>(lag)) / variance;
  }
  return std::max(kLeast, count);
}

}  // namespace planar
