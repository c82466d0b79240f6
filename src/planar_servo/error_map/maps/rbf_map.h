#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/fit/leave_one_out.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/maps/radial_kernel.h"
#include "planar_servo/error_map/maps/tail_basis.h"
#include "planar_servo/error_map/maps/valid_region.h"
#include "planar_servo/error_map/numerics/bordered_system.h"

namespace planar {

/// What determines a radial basis function map, bit for bit.
struct RbfParameters {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::VectorXd counts;    ///< samples averaged at each centre: its noise is ridge / count
  Eigen::Matrix2Xd weights;  ///< metres
  TailBasis tail_basis;
  Eigen::Matrix2Xd tail;  ///< metres, one column per term of tail_basis
  RadialKernel kernel;
  double ridge{0.0};         ///< lambda, in units of the kernel
  double signal_sigma{0.0};  ///< s_f per axis, metres
  /// Predictions with a larger standard deviation are not valid, metres. A fit sets it to that of
  /// its loneliest sample predicted by the others.
  double sigma_limit{0.0};
  ValidRegion region;
  Eigen::Matrix2Xd directions;  ///< of the tool at each centre; none unless the tail has them
};

/// An error t that is fixed in the tool's frame, R(phi) t in the base frame.
struct ToolBias {
  Eigen::Vector2d t{0.0, 0.0};  ///< metres
  double sigma{0.0};            ///< standard deviation per axis, metres
};

struct RbfFit;

/// Radial basis functions of one kernel on the samples, with ridge and tail:
/// E(p) = sum_j w_j phi(|p - c_j|) + tail q(p, d), where
/// [[Phi + ridge diag(1 / count), Q], [Q^T, 0]] [w; tail] = [E; 0]. Its standard deviation is that
/// of kriging with the same kernel: s_f sqrt(1 - [k; q]^T A^-1 [k; q]).
class RbfMap {
 public:
  /// Throws WorkError when the kernel matrix is too ill conditioned to be solved.
  explicit RbfMap(const RbfParameters& parameters);

  /// With the tool's direction (cos, sin), which counts only where the tail has it, and must then
  /// be known.
  ErrorPrediction predict(const Eigen::Vector2d& p,
                          const Eigen::Vector2d& direction = TailBasis::unknown_direction()) const;

  /// The error alone, several times as fast.
  Eigen::Vector2d predict_error(const Eigen::Vector2d& p, const Eigen::Vector2d& direction =
                                                              TailBasis::unknown_direction()) const;

  /// The standard deviation of a prediction over s_f.
  double unit_sigma(const Eigen::Vector2d& p,
                    const Eigen::Vector2d& direction = TailBasis::unknown_direction()) const;

  /// The part R(phi) t of what the tail says of the tool's direction; empty where it says nothing.
  std::optional<ToolBias> tool_bias() const;

  /// Of the samples, per axis: sqrt(ridge) s_f, metres.
  double noise_sigma() const;

  const RbfParameters& parameters() const { return parameters_; }

  /// What the samples at the named centres are missed by when all of them are left out of the fit,
  /// one column each: (A^-1)_BB^-1 w_B, metres. The other centres must determine the tail. Empty
  /// when the equations are too ill conditioned.
  std::optional<Eigen::Matrix2Xd> left_out_residuals(const std::vector<Eigen::Index>& block) const;

 private:
  friend RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis,
                        const RadialKernel& kernel, double ridge);
  RbfMap(RbfParameters parameters, BorderedSystem system);
  Eigen::Vector2d error(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const;
  double unit_sigma(const Eigen::VectorXd& kernel, const Eigen::VectorXd& q) const;

  RbfParameters parameters_;
  // The parameters' columns as rows, along which sums over the centres are fast.
  Eigen::MatrixX2d centers_;
  Eigen::MatrixX2d weights_;
  BorderedSystem system_;
};

/// s_f^2 = E^T w / (N - m) per axis, over all samples, of the weights of a fit with m terms of a
/// tail: samples averaged at a site scatter about it with variance ridge s_f^2.
double signal_variance(const MapSites& sites, const Eigen::Matrix2Xd& weights, Eigen::Index terms,
                       double ridge);

struct RbfFit {
  RbfMap map;
  LeaveOneOut left_out;
};

/// Fits to sites with given kernel, ridge and tail. Throws WorkError when the kernel matrix
/// is too ill conditioned to be solved.
RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis, const RadialKernel& kernel,
               double ridge);

}  // namespace planar
