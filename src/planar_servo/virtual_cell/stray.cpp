#include "planar_servo/virtual_cell/stray.h"

#include <cmath>

namespace planar {

double stray_length(const OutlierTruth& outliers, Random& random) {
  if (random.uniform(0.0, 1.0) >= outliers.share) return 0.0;
  return outliers.from_m * std::pow(outliers.to_m / outliers.from_m, random.uniform(0.0, 1.0));
}

}  // namespace planar
