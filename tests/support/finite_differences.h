#pragma once

#include <Eigen/Core>
#include <functional>

namespace planar::test {

/// Jacobian of `function` at `x` by central differences of fourth order with the given step: the
/// one checker for every analytic Jacobian of the project.
Eigen::MatrixXd numeric_jacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
    const Eigen::VectorXd& x, double step);

/// Largest difference between an analytic and the numeric Jacobian, relative to the latter's
/// largest element.
double jacobian_mismatch(const Eigen::MatrixXd& analytic,
                         const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                         const Eigen::VectorXd& x, double step);

}  // namespace planar::test
