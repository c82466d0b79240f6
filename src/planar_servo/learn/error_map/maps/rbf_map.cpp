#include "planar_servo/learn/error_map/maps/rbf_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

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

/// The least ratio of pivots. A smaller pivot is mostly rounding (200 unit terms of 2e-16 each).
constexpr double kSmallestPivotRatio = 1e-13;

Eigen::MatrixXd ridged_kernel_matrix(const RbfParameters& parameters) {
  Eigen::MatrixXd matrix;
  kernel_matrix(parameters.kernel, squared_distances(parameters.centers), matrix);
  matrix.diagonal().array() += parameters.ridge / parameters.counts.array();
  return matrix;
}

/// A trace added to the diagonal of K: far above rounding, far below any kernel value that matters.
constexpr double kTrace = 1e-9;

RadialKernel gaussian(double width) {
  return {KernelShape::kGaussian, width, 0.0};
}

/// Returns the kernels times the weights, plus the tail.
Eigen::Vector2d sum_of(const Eigen::MatrixX2d& weights, const Eigen::VectorXd& kernel,
                       const Eigen::Matrix2Xd& tail, const Eigen::VectorXd& q) {
  const Eigen::Vector2d sum(weights.col(0).dot(kernel), weights.col(1).dot(kernel));
  return sum + tail * q;
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
       "use a smaller width, or let the map choose width and ridge", "", Cause::kInsufficient});
}

RbfMap::RbfMap(RbfParameters parameters, std::shared_ptr<const BorderedSystem> equations)
    : parameters_(std::move(parameters)),
      centers_(parameters_.centers.transpose()),
      weights_(parameters_.weights.transpose()),
      equations_(std::move(equations)) {}

RbfMap::RbfMap(const RbfParameters& parameters) : RbfMap(parameters, map_equations(parameters)) {}

Eigen::Vector2d RbfMap::predict_error(const Eigen::Vector2d& p,
                                      const Eigen::Vector2d& direction) const {
  return sum_of(weights_, kernel_at(parameters_.kernel, centers_, p), parameters_.tail,
                parameters_.tail_basis.at(p, direction));
}

ErrorPrediction RbfMap::predict(const Eigen::Vector2d& p, const Eigen::Vector2d& direction) const {
  const Eigen::VectorXd kernel = kernel_at(parameters_.kernel, centers_, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p, direction);
  const double sigma = parameters_.signal_sigma * unit_sigma(kernel, q);
  return {sum_of(weights_, kernel, parameters_.tail, q), sigma,
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
  if (!(parameters_.ridge > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

Eigen::MatrixXd center_factor(const Eigen::Matrix2Xd& centers, double width) {
  Eigen::MatrixXd kernel;
  kernel_matrix(gaussian(width), squared_distances(centers), kernel);
  kernel.diagonal().array() += kTrace;
  if (auto factor = lower_factor(kernel)) return std::move(*factor);
  throw WorkError({fmt::format("the kernel matrix of {} centres with a width of {:.4g} mm is too "
                               "ill conditioned to be solved",
                               centers.cols(), mm(width)),
                   "use a smaller width", "", Cause::kInsufficient});
}

SparseRbfMap::SparseRbfMap(SparseRbfParameters parameters)
    : parameters_(std::move(parameters)),
      centers_(parameters_.centers.transpose()),
      weights_(parameters_.weights.transpose()),
      whitening_(inverse_of_lower(center_factor(parameters_.centers, parameters_.width))),
      open_(inverse_of_lower(parameters_.factor)) {}

Eigen::Vector2d SparseRbfMap::predict_error(const Eigen::Vector2d& p) const {
  return sum_of(weights_, kernel_at(gaussian(parameters_.width), centers_, p), parameters_.tail,
                parameters_.tail_basis.at(p));
}

ErrorPrediction SparseRbfMap::predict(const Eigen::Vector2d& p) const {
  const Eigen::VectorXd kernel = kernel_at(gaussian(parameters_.width), centers_, p);
  const Eigen::VectorXd q = parameters_.tail_basis.at(p);
  const Eigen::VectorXd whitened = whitening_.triangularView<Eigen::Lower>() * kernel;
  Eigen::VectorXd basis(kernel.size() + q.size());
  basis << whitened, q;
  const Eigen::VectorXd open = open_.triangularView<Eigen::Lower>() * basis;
  const double unit_variance =
      std::max(0.0, 1.0 - whitened.squaredNorm()) + parameters_.ridge * open.squaredNorm();
  const double sigma = parameters_.signal_sigma * std::sqrt(unit_variance);
  return {sum_of(weights_, kernel, parameters_.tail, q), sigma,
          sigma <= parameters_.sigma_limit && parameters_.region.contains(p)};
}

double SparseRbfMap::noise_sigma() const {
  return std::sqrt(parameters_.ridge) * parameters_.signal_sigma;
}

}  // namespace planar
