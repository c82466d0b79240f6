#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/rbf_families.h"
#include "planar_servo/error_map/fit/rbf_fit.h"
#include "planar_servo/error_map/judge/outlier_rule.h"

namespace planar {

struct RobustFit {
  RbfFit fit;                      ///< of the kept sites
  std::vector<Eigen::Index> kept;  ///< in order
  std::vector<Outlier> outliers;
};

/// Fits the best family to the sites that do not contradict each other.
///
/// Starting from the sites that are like their neighbours, every site is judged by what the other
/// kept sites predict with the first family, and by how well they do around it. Sites that disagree
/// are dropped, in the first rounds those that agree again are taken back, and the map is tuned
/// anew, until the choice is stable. Where the kept residuals have long tails, sites within the
/// limit of Student's t are taken back.
///
/// Throws InputError when more than a fifth of the sites would be dropped. Fewer than ten sites are
/// not judged.
RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families);

}  // namespace planar
