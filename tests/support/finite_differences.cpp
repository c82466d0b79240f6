#include "support/finite_differences.h"

namespace planar::test {

Eigen::MatrixXd numeric_jacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
    const Eigen::VectorXd& x, double step) {
  Eigen::MatrixXd jacobian(function(x).size(), x.size());
  for (Eigen::Index column = 0; column < x.size(); ++column) {
    const auto at = [&](double steps) {
      Eigen::VectorXd moved = x;
      moved[column] += steps * step;
      return function(moved);
    };
    jacobian.col(column) = (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * step);
  }
  return jacobian;
}

double jacobian_mismatch(const Eigen::MatrixXd& analytic,
                         const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                         const Eigen::VectorXd& x, double step) {
  const Eigen::MatrixXd numeric = numeric_jacobian(function, x, step);
  return (analytic - numeric).cwiseAbs().maxCoeff() / numeric.cwiseAbs().maxCoeff();
}

}  // namespace planar::test
