#include "planar_servo/error_map/maps/rbf_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/maps/bordered_system.h"

namespace planar {
namespace {

/// The least ratio of pivots of the kernel matrix. A smaller pivot is mostly rounding (200 unit
/// terms of 2e-16 each).
constexpr double kSmallestPivotRatio = 1e-13;

Eigen::MatrixXd ridged_kernel_matrix(const RbfParameters& parameters) {
  Eigen::MatrixXd matrix;
  kernel_matrix(parameters.kernel, squared_distances(parameters.centers), matrix);
  matrix.diagonal().array() += parameters.ridge / parameters.counts.array();
  return matrix;
}

}  // namespace

std::shared_ptr<const BorderedSystem> map_equations(const RbfParameters& parameters) {
  auto system = BorderedSystem::factorize(
      ridged_kernel_matrix(parameters),
      parameters.tail_basis.at_each(parameters.centers, parameters.directions));
  if (system && system->pivot_ratio() >= kSmallestPivotRatio)
    return std::make_shared<const BorderedSystem>(*std::move(system));
  throw WorkError(
      {fmt::format("the kernel matrix of {} samples with a width of {:.4g} mm and a ridge of "
                   "{:.3g} is too ill conditioned to be solved",
                   parameters.centers.cols(), mm(parameters.kernel.width), parameters.ridge),
       "use a smaller width, or let the map choose width and ridge"});
}

RbfMap::RbfMap(RbfParameters parameters, std::shared_ptr<const BorderedSystem> equations)
    : parameters_(std::move(parameters)),
      centers_(parameters_.centers.transpose()),
      weights_(parameters_.weights.transpose()),
      equations_(std::move(equations)) {}

RbfMap::RbfMap(const RbfParameters& parameters) : RbfMap(parameters, map_equations(parameters)) {}

Eigen::Vector2d RbfMap::error(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const {
  const Eigen::Vector2d sum(weights_.col(0).dot(kernel), weights_.col(1).dot(kernel));
  return sum + parameters_.tail * q;
}

Eigen::Vector2d RbfMap::predict_error(const Eigen::Vector2d& p,
                                      const Eigen::Vector2d& direction) const {
  return error(kernel_at(parameters_.kernel, centers_, p), parameters_.tail_basis.at(p, direction));
}

ErrorPrediction RbfMap::predict(const Eigen::Vector2d& p, const Eigen::Vector2d& direction) const {
  const Eigen::VectorXd kernel = kernel_at(parameters_.kernel, centers_, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p, direction);
  const double sigma = parameters_.signal_sigma * unit_sigma(kernel, q);
  return {error(kernel, q), sigma,
          sigma <= parameters_.sigma_limit && parameters_.region.contains(p)};
}

double RbfMap::unit_sigma(const Eigen::Vector2d& p, const Eigen::Vector2d& direction) const {
  return unit_sigma(kernel_at(parameters_.kernel, centers_, p),
                    parameters_.tail_basis.at(p, direction));
}

double RbfMap::unit_sigma(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const {
  return std::sqrt(std::max(0.0, 1.0 - equations_->inverse_form(kernel, q)));
}

std::optional<ToolBias> RbfMap::tool_bias() const {
  if (!parameters_.tail_basis.with_direction) return {};
  // B = [[a, b], [c, d]] contains R(phi) t = [[t_x, -t_y], [t_y, t_x]] (cos phi, sin phi).
  const Eigen::Matrix2d B = parameters_.tail.rightCols<TailBasis::kDirectionTerms>();
  const Eigen::Vector2d t(0.5 * (B(0, 0) + B(1, 1)), 0.5 * (B(1, 0) - B(0, 1)));
  const double variance =
      equations_->tail_covariance().diagonal().tail<TailBasis::kDirectionTerms>().sum() / 4.0;
  return ToolBias{t, parameters_.signal_sigma * std::sqrt(variance)};
}

std::optional<Eigen::Matrix2Xd> RbfMap::left_out_residuals(
    const std::vector<Eigen::Index>& block) const {
  const Eigen::MatrixXd weights = parameters_.weights(Eigen::all, block).transpose();
  const auto residuals = solve_positive(equations_->inverse_block(block), weights);
  if (!residuals) return {};
  return residuals->transpose();
}

double RbfMap::noise_sigma() const {
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

}  // namespace planar
