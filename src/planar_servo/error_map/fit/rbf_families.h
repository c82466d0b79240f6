#pragma once

#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/rbf_fit.h"
#include "planar_servo/error_map/fit/tuning.h"

namespace planar {

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
/// tried first, because it states its ignorance more honestly.
constexpr RbfFamily kManyScales{KernelShape::kMultiquadric, 2};
constexpr RbfFamily kSmooth{KernelShape::kGaussian, 3};

TunedFamily tune(const MapSites& sites, const RbfFamily& family);

/// Tunes each of `families` in parallel. All get the tool's direction in the tail if the sites
/// determine those terms and the first family is clearly better with them (as in best_of()).
std::vector<TunedFamily> tune(const MapSites& sites, const std::vector<RbfFamily>& families);

/// Tunes to sites that are nearly those of `before`, starting from its kernel.
TunedFamily retune(const MapSites& sites, const TunedFamily& before);

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family);

/// Fits the paper's map: a Gaussian of the given width (metres) without ridge and tail. Throws like
/// the other fit_rbf().
RbfFit fit_hand_width(const MapSites& sites, double width);

/// Returns the family with the smallest leave-one-out error; all are tuned to the same sites. The
/// first one stands unless another one's sum of squares is smaller by more than the standard error
/// of the difference, taken site by site.
const TunedFamily& best_of(const std::vector<TunedFamily>& families);

}  // namespace planar
