#pragma once

#include <Eigen/Core>
#include <functional>

namespace planar::test {

/// Returns the Jacobian of `function` at `x` by central differences of fourth order with the given
/// step. It checks every analytic Jacobian of the project.
Eigen::MatrixXd numeric_jacobian(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
    const Eigen::VectorXd& x, double step);

/// Returns the largest difference between an analytic and the numeric Jacobian, relative to the
/// largest element of the numeric one.
double jacobian_mismatch(const Eigen::MatrixXd& analytic,
                         const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
                         const Eigen::VectorXd& x, double step);

}  // namespace planar::test
