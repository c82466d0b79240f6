#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "planar_servo/error_map/judge/outlier_rule.h"

namespace planar {

/// A map fitted to sites, not yet judged.
struct MethodFit {
  ErrorMap map;
  std::vector<Eigen::Index> kept;  ///< sites, in order
  std::vector<Outlier> outliers;
  Eigen::Matrix2Xd residuals;  ///< of the kept sites when each is left out, metres
  Eigen::VectorXd sigmas;      ///< of each residual per axis; see MapPlaces
};

/// Fits by the method of `problem` to sites merged of its samples. Throws as fit_error_map() does.
MethodFit fit_by_method(const MapSites& sites, const MapProblem& problem, const Progress& progress);

}  // namespace planar
