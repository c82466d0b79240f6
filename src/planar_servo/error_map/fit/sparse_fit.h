#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/outliers.h"
#include "planar_servo/error_map/maps/sparse_rbf_map.h"

namespace planar {

struct SparseFit {
  SparseRbfMap map;
  std::vector<Eigen::Index> kept;  ///< sites, in order
  std::vector<Outlier> outliers;
  /// Leave-one-out residuals of the kept sites, metres. All have the mean leverage, because there
  /// are many more sites than centres.
  Eigen::Matrix2Xd residuals;
  Eigen::VectorXd sigmas;  ///< of the residuals per axis, metres
};

/// Fits a sparse map to thousands up to a million sites. Centres are spread evenly among the sites;
/// generalized cross-validation on an evenly drawn part chooses width and ridge. Outliers are left
/// out by the rule of fit_without_outliers(), with the sites nearest to the same centre as
/// neighbours; it throws like that function. Time grows linearly with the sites.
SparseFit fit_sparse(const MapSites& sites, const Progress& progress = {});

}  // namespace planar
