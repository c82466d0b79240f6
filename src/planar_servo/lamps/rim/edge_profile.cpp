#include "planar_servo/lamps/rim/edge_profile.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace planar {
namespace {

constexpr int kUnknowns = 6;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

Unknowns unknowns(double dark, double bright, double dark_slope, double bright_slope, double offset,
                  double blur) {
  Unknowns x;
  x << dark, bright, dark_slope, bright_slope, offset, blur;
  return x;
}

Unknowns unknowns(const EdgeProfile& p) {
  return unknowns(p.dark, p.bright, p.dark_slope, p.bright_slope, p.offset_px, p.blur_px);
}

}  // namespace

EdgeShape edge_shape(double x) {
  constexpr double kRootHalf = 0.70710678118654752, kPeak = 0.39894228040143268;
  return {0.5 * std::erfc(kRootHalf * x), kPeak * std::exp(-0.5 * x * x)};
}

EdgeProfile fit_edge_profile(const RimBand::Places& distance_px, const RimBand::Places& level,
                             const RimBand::Places& weight, const EdgeProfile& start) {
  constexpr int kSteps = 2;
  constexpr double kLeastBlur_px = 0.4, kMostBlur_px = 4.0;
  // These are the standard deviations of the prior.
  constexpr double kOffset_px = 1.0, kBlur_px = 0.5, kSlope = 0.05;
  const double contrast = start.bright - start.dark;
  const Unknowns sigma =
      unknowns(contrast, contrast, kSlope * contrast, kSlope * contrast, kOffset_px, kBlur_px);
  const Unknowns expected = unknowns(start);
  EdgeProfile profile = start;
  for (int i = 0; i < kSteps; ++i) {
    Information information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    Unknowns right = information * (expected - unknowns(profile));
    for (Eigen::Index j = 0; j < level.size(); ++j) {
      if (weight[j] == 0.0) continue;
      const double d = distance_px[j];
      const EdgeShape edge = profile.shape(d);
      const double dark = profile.dark + profile.dark_slope * d;
      const double step = profile.bright + profile.bright_slope * d - dark;
      const double slope = step * edge.density / profile.blur_px;
      const Unknowns row =
          unknowns(1.0 - edge.share, edge.share, d * (1.0 - edge.share), d * edge.share, slope,
                   slope * (d - profile.offset_px) / profile.blur_px);
      information.noalias() += weight[j] * row * row.transpose();
      right += weight[j] * (level[j] - dark - step * edge.share) * row;
    }
    const Unknowns x = unknowns(profile) + information.llt().solve(right);
    profile = {x[0], x[1], x[2], x[3], x[4], std::clamp(x[5], kLeastBlur_px, kMostBlur_px)};
  }
  return profile;
}

}  // namespace planar
