#pragma once

#include <Eigen/Core>
#include <vector>

#include "error_map/gaussian_rbf.h"
#include "error_map/map_sites.h"

namespace planar {

struct Outlier {
  Eigen::Index site{0};
  double residual{0.0};  ///< distance from what the other sites predict there, metres
  double limit{0.0};     ///< the largest residual that would have been kept, metres
};

struct RobustFit {
  GaussianRbfFit fit;              ///< of the kept sites
  std::vector<Eigen::Index> kept;  ///< in order
  std::vector<Outlier> outliers;
};

/// Starts from the sites that are like their neighbours, fits a tuned map, judges every site by
/// what the OTHER kept sites predict there, drops those that disagree (and at first takes back
/// those that no longer do), until the choice is stable. Throws InputError when more than a fifth
/// of the sites would be dropped. Fewer than ten sites are not judged.
RobustFit fit_without_outliers(const MapSites& sites);

}  // namespace planar
