#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/rbf_families.h"
#include "planar_servo/error_map/judge/outlier_rule.h"
#include "planar_servo/error_map/maps/rbf_map.h"

namespace planar {

struct RobustFit {
  RbfFit fit;                      ///< of the kept sites
  std::vector<Eigen::Index> kept;  ///< in order
  std::vector<Outlier> outliers;
};

/// Starts from the sites that are like their neighbours, tunes the families, judges every site by
/// what the OTHER kept sites predict there with the first family and by how well they do around it,
/// drops those that disagree (and at first takes back those that no longer do), tunes anew, until
/// the choice is stable; takes back those that are within Student's limit where the residuals of
/// the kept ones have long tails; then fits the best family. Throws InputError when more than a
/// fifth of the sites would be dropped. Fewer than ten sites are not judged.
RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families);

}  // namespace planar
