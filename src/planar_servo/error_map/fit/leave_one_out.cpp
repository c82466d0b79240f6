#include "planar_servo/error_map/fit/leave_one_out.h"

#include <cmath>

#include "planar_servo/error_map/numerics/bordered_system.h"

namespace planar {

LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights) {
  const Eigen::ArrayXd diagonal = system.inverse_diagonal();
  return {(weights.array().rowwise() / diagonal.transpose()).matrix(), diagonal.rsqrt()};
}

double standard_error_of_sum(const Eigen::ArrayXd& draws) {
  const auto n = static_cast<double>(draws.size());
  return std::sqrt((draws - draws.mean()).square().sum() * n / (n - 1.0));
}

}  // namespace planar
