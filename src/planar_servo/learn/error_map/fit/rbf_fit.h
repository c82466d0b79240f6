#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/maps/rbf_basis.h"
#include "planar_servo/learn/error_map/maps/rbf_map.h"

namespace planar {

struct TunedKernel {
  RadialKernel kernel;
  double ridge{0.0};  ///< in units of the kernel
  /// Change of the best ridge with the width there: d log ridge / d log width.
  double slope{0.0};
  double loo_rms{0.0};  ///< leave-one-out error over all samples, metres
  /// Squared leave-one-out error of each site that decided, times its count; square metres.
  Eigen::ArrayXd squared_misses;
};

/// Chooses the kernel's width and ridge with the smallest leave-one-out error: by a coarse grid
/// over the logarithms of both on a hundred sites, then by BOBYQA [Powell 2009] from its best
/// point. At most five hundred evenly drawn sites decide.
TunedKernel tune_rbf(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape);

/// Residuals of the samples when each in turn is left out of the fit, computed without refitting.
struct LeaveOneOut {
  Eigen::Matrix2Xd residuals;  ///< E_i minus the prediction of the others, one column each
  /// Standard deviation of a residual divided by s_f: 1 / sqrt((A^-1)_ii).
  Eigen::VectorXd unit_sigmas;
};

/// Returns the standard error of the sum of independent draws, of which there are at least two.
double standard_error_of_sum(const Eigen::ArrayXd& draws);

struct RbfFit {
  RbfMap map;
  LeaveOneOut left_out;
};

/// Fits a map with this kernel, ridge and tail. Throws WorkError when that is too ill conditioned.
RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis, const RadialKernel& kernel,
               double ridge);

/// A family of radial basis function maps that differ only in width, ridge and weights.
struct RbfFamily {
  KernelShape shape{KernelShape::kGaussian};
  int tail_degree{1};
  bool with_direction{false};
};

struct TunedFamily {
  RbfFamily family;
  TailBasis tail_basis;
  TunedKernel tuned;
};

/// The classical choice: one width.
constexpr RbfFamily kOneWidth{KernelShape::kGaussian, 1};
/// The multiquadric represents features of any scale from its width upwards (a knee, a seam). It is
/// tried first, because its stated deviations grow where it knows less.
constexpr RbfFamily kManyScales{KernelShape::kMultiquadric, 2};
constexpr RbfFamily kSmooth{KernelShape::kGaussian, 3};

TunedFamily tune(const MapSites& sites, const RbfFamily& family);

/// Tunes each of `families` in parallel. All get the tool's direction in the tail if the sites
/// determine those terms and the first family is clearly better with them (as in best_of()).
std::vector<TunedFamily> tune(const MapSites& sites, const std::vector<RbfFamily>& families);

/// Tunes to sites that are nearly those of `before`, starting from its kernel, without the grid.
TunedFamily retune(const MapSites& sites, const TunedFamily& before);

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family);

/// Fits the paper's map, a Gaussian of this width (metres) without ridge and tail; throws alike.
RbfFit fit_hand_width(const MapSites& sites, double width);

/// Returns the family, tuned to the same sites, with the smallest leave-one-out error: the first
/// unless another's sum of squares is smaller by more than the difference's standard error by site.
const TunedFamily& best_of(const std::vector<TunedFamily>& families);

}  // namespace planar
