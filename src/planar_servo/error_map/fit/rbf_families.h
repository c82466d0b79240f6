#pragma once

#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/tuning.h"
#include "planar_servo/error_map/maps/rbf_map.h"

namespace planar {

/// Radial basis function maps that differ in width, ridge and weights only.
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

/// One width, the classical choice.
constexpr RbfFamily kOneWidth{KernelShape::kGaussian, 1};
/// Features of any scale from the width upwards (a knee, a seam) take the multiquadric; it states
/// how little it knows more honestly, too, and so comes first.
constexpr RbfFamily kManyScales{KernelShape::kMultiquadric, 2};
constexpr RbfFamily kSmooth{KernelShape::kGaussian, 3};

TunedFamily tune(const MapSites& sites, const RbfFamily& family);

/// Each of `families`, side by side; all of them with the tool's direction in the tail where the
/// sites determine those terms and the first family is clearly better with them (as in `best_of`).
std::vector<TunedFamily> tune(const MapSites& sites, const std::vector<RbfFamily>& families);

/// The same from what nearly the same sites were tuned to.
TunedFamily retune(const MapSites& sites, const TunedFamily& before);

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family);

/// As the paper has it: a Gaussian of the given width (metres) without ridge and tail. Throws like
/// the other.
RbfFit fit_hand_width(const MapSites& sites, double width);

/// The family with the smallest leave-one-out error, all tuned to the same sites. The first one
/// stands unless another one's sum of squares is smaller by more than the standard error of the
/// difference, taken site by site.
const TunedFamily& best_of(const std::vector<TunedFamily>& families);

}  // namespace planar
