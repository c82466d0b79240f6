#pragma once

#include <Eigen/Core>
#include <limits>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/valid_region.h"

namespace planar {

/// Inverse distance weighting [Shepard 1968], the paper's baseline: E(p) = sum w_i E_i / sum w_i
/// with w_i = |p - p_i|^-2, and E_i at a sample. It states no uncertainty.
struct IdwMap {
  Eigen::Matrix2Xd centers;  ///< metres, distinct
  Eigen::Matrix2Xd errors;   ///< metres
  ValidRegion region;

  ErrorPrediction predict(const Eigen::Vector2d& p) const;
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p) const;
  double noise_sigma() const { return std::numeric_limits<double>::quiet_NaN(); }
};

IdwMap idw_map(const MapSites& sites);

/// Returns E_i minus the prediction of the other samples, one column each, metres.
Eigen::Matrix2Xd leave_one_out_residuals(const IdwMap& map);

}  // namespace planar
