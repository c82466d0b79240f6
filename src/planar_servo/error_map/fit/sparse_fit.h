#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/core/progress.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/judge/outlier_rule.h"
#include "planar_servo/error_map/maps/sparse_rbf_map.h"

namespace planar {

struct SparseFit {
  SparseRbfMap map;
  std::vector<Eigen::Index> kept;  ///< sites, in order
  std::vector<Outlier> outliers;
  /// Of the kept sites; as if left out, by the mean leverage (there are many more sites than
  /// centres); metres.
  Eigen::Matrix2Xd residuals;
};

/// Fits a sparse map to many sites (thousands to a million): centres spread evenly among them,
/// width and ridge by generalized cross-validation of an evenly drawn part, outliers left out by
/// the rule of `fit_without_outliers` with the sites nearest to the same centre as neighbours. Time
/// grows linearly. Throws like it.
SparseFit fit_sparse(const MapSites& sites, const Progress& progress = {});

}  // namespace planar
