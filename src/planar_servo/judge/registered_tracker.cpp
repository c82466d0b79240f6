#include "planar_servo/judge/registered_tracker.h"

#include <cmath>
#include <map>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/pose.h"

namespace planar {
namespace {

using MotionJacobian = Eigen::Matrix<double, 3, 6>;

std::vector<MonumentReading> monument_readings(const CellSettings& cell,
                                               const std::vector<MonumentSeen>& seen) {
  std::vector<MonumentReading> readings;
  readings.reserve(seen.size());
  for (const MonumentSeen& monument : seen)
    readings.push_back(
        {monument.id, monument.reading.p_L, cell.tracker.sigma_at(monument.reading.p_L.norm())});
  return readings;
}

/// Returns how a place in the base frame follows a small shift and turn of the registration.
MotionJacobian motion_jacobian(const Eigen::Vector3d& p_B) {
  MotionJacobian J;
  J << Eigen::Matrix3d::Identity(), -cross_matrix(p_B);
  return J;
}

}  // namespace

RegisteredTracker::RegisteredTracker(const CellSettings& cell,
                                     const std::vector<MonumentSeen>& seen)
    : tracker_(cell.tracker), datum_(register_datum(cell.datum, monument_readings(cell, seen))) {
  std::map<std::string, double> information;  // of each monument's mean, per m^2
  for (const MonumentSeen& monument : seen)
    information[monument.id] += 1.0 / variance_of(monument.reading);
  // The fit weighs all monuments alike: cov = M^-1 (sum variance J^T J) M^-1, M = sum J^T J.
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero(), noise = normal;
  for (const Monument& monument : cell.datum) {
    const auto found = information.find(monument.id);
    if (found == information.end() || monument.id == datum_.left_out) continue;
    const MotionJacobian J = motion_jacobian(monument.p_B);
    normal += J.transpose() * J;
    noise += J.transpose() * J / found->second;
  }
  covariance_ = solve_symmetric(normal, solve_symmetric(normal, noise).transpose());
}

double RegisteredTracker::variance_of(const TrackerReading& reading) const {
  const double sigma = tracker_.sigma_at(reading.p_L.norm());
  return sigma * sigma / reading.averaged;
}

double RegisteredTracker::sigma(const TrackerReading& reading) const {
  const Eigen::Matrix<double, 2, 6> J = motion_jacobian(place(reading)).topRows<2>();
  return std::sqrt(variance_of(reading) + 0.5 * (J * covariance_ * J.transpose()).trace());
}

}  // namespace planar
