#pragma once

#include <Eigen/Core>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/maps/radial_kernel.h"
#include "planar_servo/error_map/maps/tail_basis.h"
#include "planar_servo/error_map/maps/valid_region.h"

namespace planar {

/// Determines a sparse map, bit for bit. With m centres, t tail terms and K = L L^T between the
/// centres, b~(p) = [L^-1 k(p); q(p)].
struct SparseRbfParameters {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::Matrix2Xd weights;  ///< metres, m
  TailBasis tail_basis;
  Eigen::Matrix2Xd tail;  ///< metres, t
  double width{0.0};      ///< of the Gaussian, metres
  double ridge{0.0};      ///< in units of the kernel
  /// Lower factor of A = B^T B + ridge diag(I, 0), (m + t) x (m + t), where the rows of B are b~ of
  /// each sample.
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
  Eigen::MatrixX2d centers_;
  Eigen::MatrixX2d weights_;
  Eigen::MatrixXd whitening_;  ///< L^-1
  Eigen::MatrixXd open_;       ///< inverse of the parameters' factor
};

/// Returns the lower factor of K between the centres. A small addition to its diagonal keeps K
/// positive definite; throws WorkError when it is not.
Eigen::MatrixXd center_factor(const Eigen::Matrix2Xd& centers, double width);

}  // namespace planar
