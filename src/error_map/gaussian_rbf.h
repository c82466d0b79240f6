#pragma once

#include <Eigen/Core>

#include "error_map/bordered_system.h"
#include "error_map/error_sample.h"
#include "error_map/leave_one_out.h"
#include "error_map/map_sites.h"
#include "error_map/tail_basis.h"
#include "error_map/valid_region.h"

namespace planar {

/// What determines a Gaussian map, bit for bit.
struct GaussianRbfParameters {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::VectorXd counts;    ///< samples averaged at each centre: its noise is ridge / count
  Eigen::Matrix2Xd weights;  ///< metres
  TailBasis tail_basis;
  Eigen::Matrix2Xd tail;     ///< metres, one column per term of tail_basis
  double width{0.0};         ///< sigma of the Gaussian, metres
  double ridge{0.0};         ///< lambda, in units of the kernel
  double signal_sigma{0.0};  ///< s_f per axis, metres
  /// Predictions with a larger standard deviation are not valid, metres. A fit sets it to that of
  /// its loneliest sample predicted by the others.
  double sigma_limit{0.0};
  ValidRegion region;
};

/// Gaussian radial basis functions of one width on the samples, with ridge and tail:
/// E(p) = sum_j w_j exp(-|p - c_j|^2 / (2 width^2)) + tail q(p), where
/// [[Phi + ridge diag(1 / count), Q], [Q^T, 0]] [w; tail] = [E; 0]. Its standard deviation is that
/// of kriging with the same kernel: s_f sqrt(1 - [k; q]^T A^-1 [k; q]).
class GaussianRbfMap {
 public:
  /// Throws WorkError when the kernel matrix is too ill conditioned to be solved.
  explicit GaussianRbfMap(GaussianRbfParameters parameters);

  ErrorPrediction predict(const Eigen::Vector2d& p) const;

  /// The standard deviation of a prediction over s_f.
  double unit_sigma(const Eigen::Vector2d& p) const;

  /// Of the samples, per axis: sqrt(ridge) s_f, metres.
  double noise_sigma() const;

  const GaussianRbfParameters& parameters() const { return parameters_; }

 private:
  double unit_sigma(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const;

  GaussianRbfParameters parameters_;
  BorderedSystem system_;
};

struct GaussianRbfFit {
  GaussianRbfMap map;
  LeaveOneOut left_out;
};

/// Fits to sites with given width (metres), ridge and tail. Throws WorkError when the kernel matrix
/// is too ill conditioned to be solved.
GaussianRbfFit fit_gaussian_rbf(const MapSites& sites, const TailBasis& tail_basis, double width,
                                double ridge);

}  // namespace planar
