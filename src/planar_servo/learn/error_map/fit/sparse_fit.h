#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/fit/outliers.h"
#include "planar_servo/learn/error_map/maps/rbf_basis.h"
#include "planar_servo/learn/error_map/maps/rbf_map.h"

namespace planar {

/// Gaussians about centres, and the terms of a tail. With K = L L^T between the centres the
/// Gaussians are taken as k~ = L^-1 k, because the equations stay well conditioned in b~(p) =
/// [k~(p); q(p)].
struct SparseBasis {
  Eigen::Matrix2Xd centers;  ///< metres
  double width{0.0};         ///< metres
  TailBasis tail_basis;
  Eigen::MatrixXd factor;  ///< L

  Eigen::Index size() const { return centers.cols() + tail_basis.terms(); }
  /// Returns [k; q] of each column of `positions`, one row each.
  Eigen::MatrixXd plain_at_each(const Eigen::Matrix2Xd& positions) const;
  /// Returns b~ of each column of `positions`, one row each.
  Eigen::MatrixXd at_each(const Eigen::Matrix2Xd& positions) const;
  /// Converts weights of b~ to those of [k; q] that give the same sum.
  Eigen::MatrixX2d plain_weights(const Eigen::MatrixX2d& weights) const;
};

/// Holds all that a ridge fit needs of its samples, so that they need not be held as a matrix.
struct SparseStatistics {
  Eigen::MatrixXd gram;        ///< B^T B with rows b~, lower triangle
  Eigen::MatrixX2d projected;  ///< B^T E, metres
  double squares{0.0};         ///< sum of |E|^2, square metres
  double count{0.0};           ///< number of samples; of sites where their samples share noise

  /// Adds other sums, or takes them away with a `sign` of -1.
  void add(const SparseStatistics& other, double sign = 1.0);
};

/// Sums over the named sites. It uses several threads; the result does not depend on their number.
SparseStatistics statistics_of(const SparseBasis& basis, const MapSites& sites,
                               const std::vector<Eigen::Index>& which);

struct RidgeFit {
  Eigen::MatrixXd factor;        ///< lower factor of A
  Eigen::MatrixX2d weights;      ///< of b~, metres
  double residual_squares{0.0};  ///< sum of |r|^2, square metres
  double freedom{0.0};           ///< trace of the hat matrix

  /// Returns the rms of |r| by generalized cross-validation [Golub, Heath and Wahba 1979], metres:
  /// the leave-one-out error if every sample had the mean leverage.
  double gcv_rms(double count) const;
};

/// Solves A weights = B^T E with A = B^T B + ridge I, without ridge on the last `free` terms. Empty
/// when A is not positive definite to working precision.
std::optional<RidgeFit> solve_ridge(const SparseStatistics& statistics, Eigen::Index free,
                                    double ridge);

struct SparseFit {
  SparseRbfMap map;
  std::vector<Eigen::Index> kept;  ///< sites, in order
  std::vector<Outlier> outliers;
  /// Leave-one-out residuals of the kept sites, metres; all with the mean leverage.
  Eigen::Matrix2Xd residuals;
  Eigen::VectorXd sigmas;  ///< of the residuals per axis, metres
};

/// Fits a sparse map to thousands up to a million sites. Centres are spread evenly among the sites;
/// generalized cross-validation on an evenly drawn part chooses width and ridge. Outliers are left
/// out by the rule of fit_without_outliers(), with the sites nearest to the same centre as
/// neighbours; it throws like that function. Time grows linearly with the sites.
SparseFit fit_sparse(const MapSites& sites, const Progress& progress = {});

}  // namespace planar
