#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/maps/rbf_basis.h"

namespace planar {

/// Inverse distance weighting [Shepard 1968], the paper's baseline: E(p) = sum w_i E_i / sum w_i
/// with w_i = |p - p_i|^-2, and E_i at a sample. It states no uncertainty.
struct IdwMap {
  Eigen::Matrix2Xd centers;  ///< metres, distinct
  Eigen::Matrix2Xd errors;   ///< metres
  ValidRegion region;

  ErrorPrediction predict(const Eigen::Vector2d& p) const;
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p) const;
  double noise_sigma() const { return std::numeric_limits<double>::quiet_NaN(); }
};

IdwMap idw_map(const MapSites& sites);

/// Returns E_i minus the prediction of the other samples, one column each, metres.
Eigen::Matrix2Xd leave_one_out_residuals(const IdwMap& map);

class BorderedSystem;

/// Determines a radial basis function map, bit for bit.
struct RbfParameters {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::VectorXd counts;    ///< samples averaged at each centre, whose noise is ridge / count
  Eigen::Matrix2Xd weights;  ///< metres
  TailBasis tail_basis;
  Eigen::Matrix2Xd tail;  ///< metres, one column per term of tail_basis
  RadialKernel kernel;
  double ridge{0.0};         ///< in units of the kernel
  double signal_sigma{0.0};  ///< s_f per axis, metres
  /// Predictions with a larger standard deviation are not valid, metres. A fit sets it to the
  /// largest standard deviation of a sample that the others predict.
  double sigma_limit{0.0};
  ValidRegion region;
  Eigen::Matrix2Xd directions;  ///< of the tool at each centre; none unless the tail has them
};

/// An error t that is fixed in the tool's frame; it is R(phi) t in the base frame.
struct ToolBias {
  Eigen::Vector2d t{0.0, 0.0};  ///< metres
  double sigma{0.0};            ///< standard deviation per axis, metres
};

/// A map of radial basis functions of one kernel about the samples, with ridge and tail: E(p) =
/// sum_j w_j phi(|p - c_j|) + tail q(p, d), where [[Phi + ridge diag(1 / count), Q], [Q^T, 0]] [w;
/// tail] = [E; 0]. Its standard deviation is that of kriging with the same kernel: s_f sqrt(1 - [k;
/// q]^T A^-1 [k; q]).
class RbfMap {
 public:
  /// Throws WorkError when the kernel matrix is too ill conditioned to be solved.
  explicit RbfMap(const RbfParameters& parameters);
  /// Takes the map_equations() of these parameters from a fit that has solved them already.
  RbfMap(RbfParameters parameters, std::shared_ptr<const BorderedSystem> equations);
  /// Predicts at p. Only a tail with direction needs `direction`, the tool's (cos phi, sin phi).
  ErrorPrediction predict(const Eigen::Vector2d& p,
                          const Eigen::Vector2d& direction = TailBasis::unknown_direction()) const;
  /// Returns the error without its standard deviation, several times as fast.
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p, const Eigen::Vector2d& direction =
                                                              TailBasis::unknown_direction()) const;
  /// Returns the standard deviation of a prediction divided by s_f.
  double unit_sigma(const Eigen::Vector2d& p,
                    const Eigen::Vector2d& direction = TailBasis::unknown_direction()) const;
  /// Returns the part R(phi) t of the tail's terms in the direction; empty where it has none.
  std::optional<ToolBias> tool_bias() const;
  /// Returns the noise's deviation per axis, sqrt(ridge) s_f, metres; NaN without ridge.
  double noise_sigma() const;

  const RbfParameters& parameters() const { return parameters_; }
  /// Returns the residuals of these centres when all are left out of the fit, columns, metres:
  /// ((A^-1)_BB)^-1 w_B. The others must determine the tail. Empty if too ill conditioned.
  std::optional<Eigen::Matrix2Xd> left_out_residuals(const std::vector<Eigen::Index>& block) const;

 private:
  double unit_sigma(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const;

  RbfParameters parameters_;
  // These are the parameters' columns as rows, along which sums over the centres are fast.
  Eigen::MatrixX2d centers_, weights_;
  std::shared_ptr<const BorderedSystem> equations_;
};

/// Returns the factors of the matrix [[Phi + ridge diag(1 / count), Q], [Q^T, 0]] of a map whose
/// weights and tail may still be missing. Throws WorkError when the matrix is too ill conditioned.
std::shared_ptr<const BorderedSystem> map_equations(const RbfParameters& parameters);

/// Determines a sparse map, bit for bit. With m centres, t tail terms and K = L L^T between the
/// centres, b~(p) = [L^-1 k(p); q(p)].
struct SparseRbfParameters {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::Matrix2Xd weights;  ///< metres, m
  TailBasis tail_basis;
  Eigen::Matrix2Xd tail;  ///< metres, t
  double width{0.0};      ///< of the Gaussian, metres
  double ridge{0.0};      ///< in units of the kernel
  /// Lower factor of A = B^T B + ridge diag(I, 0), (m + t) x (m + t); B has rows b~ by sample.
  Eigen::MatrixXd factor;
  double signal_sigma{0.0};  ///< s_f per axis, metres
  double sigma_limit{0.0};   ///< larger standard deviations are not valid, metres
  ValidRegion region;
};

/// A Gaussian map of many samples on few centres ("subset of regressors"): E(p) = [weights, tail]
/// b(p) with A [weights, tail]^T = B^T E. Its variance s_f^2 (1 - k^T K^-1 k + ridge b^T A^-1 b) is
/// what the centres cannot represent plus what the samples leave open [Quinonero-Candela and
/// Rasmussen 2005, deterministic training conditional].
class SparseRbfMap {
 public:
  /// Throws WorkError when the equations are too ill conditioned to be solved.
  explicit SparseRbfMap(SparseRbfParameters parameters);

  ErrorPrediction predict(const Eigen::Vector2d& p) const;
  /// Returns the error without its standard deviation, many times as fast.
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p) const;
  /// Returns the standard deviation of the samples' noise per axis, sqrt(ridge) s_f, metres.
  double noise_sigma() const;

  const SparseRbfParameters& parameters() const { return parameters_; }

 private:
  SparseRbfParameters parameters_;
  Eigen::MatrixX2d centers_, weights_;
  Eigen::MatrixXd whitening_;  ///< L^-1
  Eigen::MatrixXd open_;       ///< inverse of the parameters' factor
};

/// Returns the lower factor of K between the centres. A small addition to its diagonal keeps K
/// positive definite; throws WorkError when it is not.
Eigen::MatrixXd center_factor(const Eigen::Matrix2Xd& centers, double width);

}  // namespace planar
