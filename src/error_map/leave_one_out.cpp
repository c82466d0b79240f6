#include "error_map/leave_one_out.h"

#include <cmath>

namespace planar {

LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights) {
  const Eigen::ArrayXd diagonal = system.inverse_diagonal();
  return {(weights.array().rowwise() / diagonal.transpose()).matrix(), diagonal.rsqrt()};
}

double rms_norm(const Eigen::Matrix2Xd& columns) {
  return std::sqrt(columns.squaredNorm() / static_cast<double>(columns.cols()));
}

}  // namespace planar
