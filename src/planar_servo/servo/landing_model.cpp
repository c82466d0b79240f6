#include "planar_servo/servo/landing_model.h"

#include <algorithm>

namespace planar {
namespace {

/// The guard's distance is half as long again as any that was seen at the calibration: three
/// deviations of them.
constexpr double kDeviationsInDistance = 3.0;
/// A guess at the scatter of an arm that is fit for positioning; looks soon replace it.
constexpr double kGuessedScatter_m = 5e-6;

}  // namespace

LandingPrior UnknownLandings::at(const Joints& /*theta_c*/, const TipMeasurement& look) const {
  const double landing_m = distance_m_ / kDeviationsInDistance;
  const double lasting_variance =
      look.uncertainty_m * look.uncertainty_m - look.noise_m() * look.noise_m();
  LandingPrior prior;
  prior.covariance.diagonal() << Eigen::Vector2d::Constant(landing_m * landing_m),
      Eigen::Vector2d::Constant(std::max(0.0, lasting_variance));
  prior.scatter_m = prior.short_scatter_m = kGuessedScatter_m;
  return prior;
}

}  // namespace planar
