#include "planar_servo/error_map/maps/idw_map.h"

namespace planar {
namespace {

/// Weights are divided by the nearest sample's, so that none overflows.
Eigen::Vector2d weighted_mean(const Eigen::Matrix2Xd& errors, const Eigen::ArrayXd& distance2) {
  Eigen::Index nearest = 0;
  const double smallest = distance2.minCoeff(&nearest);
  if (smallest == 0.0) return errors.col(nearest);
  const Eigen::VectorXd weights = smallest / distance2;
  return errors * weights / weights.sum();
}

Eigen::ArrayXd squared_distances_to(const Eigen::Matrix2Xd& centers, const Eigen::Vector2d& p) {
  return (centers.colwise() - p).colwise().squaredNorm();
}

}  // namespace

ErrorPrediction IdwMap::predict(const Eigen::Vector2d& p) const {
  return {predict_error(p), noise_sigma(), region.contains(p)};
}

Eigen::Vector2d IdwMap::predict_error(const Eigen::Vector2d& p) const {
  return weighted_mean(errors, squared_distances_to(centers, p));
}

IdwMap idw_map(const MapSites& sites) {
  return {sites.positions, sites.errors, region_around(sites.positions)};
}

Eigen::Matrix2Xd leave_one_out_residuals(const IdwMap& map) {
  Eigen::Matrix2Xd residuals(2, map.centers.cols());
  for (Eigen::Index i = 0; i < residuals.cols(); ++i) {
    Eigen::ArrayXd distance2 = squared_distances_to(map.centers, map.centers.col(i));
    distance2[i] = std::numeric_limits<double>::infinity();
    residuals.col(i) = map.errors.col(i) - weighted_mean(map.errors, distance2);
  }
  return residuals;
}

}  // namespace planar
