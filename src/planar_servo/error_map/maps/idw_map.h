#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/valid_region.h"

namespace planar {

/// Inverse distance weighting [Shepard 1968]: E(p) = sum w_i E_i / sum w_i, w_i = |p - p_i|^-2; at
/// a sample its own value. The paper's baseline; it states no uncertainty.
struct IdwMap {
  Eigen::Matrix2Xd centers;  ///< metres, distinct
  Eigen::Matrix2Xd errors;   ///< metres
  ValidRegion region;

  ErrorPrediction predict(const Eigen::Vector2d& p) const;
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p) const;
};

IdwMap idw_map(const MapSites& sites);

/// E_i minus what the other samples predict there, one column each, metres.
Eigen::Matrix2Xd leave_one_out_residuals(const IdwMap& map);

}  // namespace planar
