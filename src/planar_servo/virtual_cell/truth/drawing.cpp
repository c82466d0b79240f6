#include "planar_servo/virtual_cell/truth/drawing.h"

#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {

double either_sign(Random& random, double lower, double upper) {
  const double magnitude = random.uniform(lower, upper);
  return random.uniform(-1.0, 1.0) < 0.0 ? -magnitude : magnitude;
}

double near_median(Random& random, double median) {
  return median * random.uniform(0.7, 1.3);
}

Eigen::Vector2d any_direction(Random& random, double lower, double upper) {
  const double length = random.uniform(lower, upper);
  return length * rotation2d(random.uniform(-kPi, kPi)).col(0);
}

Harmonic harmonic(Random& random, int order, double lower, double upper) {
  const double amplitude = random.uniform(lower, upper);
  return {amplitude, random.uniform(-kPi, kPi), order};
}

double stray_length(const OutlierTruth& outliers, Random& random) {
  if (random.uniform(0.0, 1.0) >= outliers.share) return 0.0;
  return outliers.from_m * std::pow(outliers.to_m / outliers.from_m, random.uniform(0.0, 1.0));
}

}  // namespace planar
