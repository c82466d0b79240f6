#include "planar_servo/lamps/rim/coarse_outline.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/lamps/rim/outline_fit.h"

namespace planar {
namespace {

constexpr double kOrdinaryBlur_px = 0.9;

struct CoarseEdges {
  PerNormal offset_px;
  NormalFlags found;
};

/// Finds on each normal, from outside, the crossing of the level half way between its two ends.
CoarseEdges half_level_edges(const RimBand& band, double contrast) {
  constexpr double kLeastFall = 0.2;
  constexpr int kEnd = 3;
  const Eigen::Index count = band.normals.count(), last = RimBand::kPlaces - 1;
  CoarseEdges edges{PerNormal::Zero(count), NormalFlags::Constant(count, false)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto level = band.level.col(k);
    const double bright = level.head<kEnd>().mean(), dark = level.tail<kEnd>().mean();
    if (bright - dark < kLeastFall * contrast) continue;
    const auto half = static_cast<float>(0.5 * (bright + dark));
    Eigen::Index j = last - 1;
    while (j > 0 && level[j] < half) --j;
    if (level[j] < half) continue;
    const double share = (level[j] - half) / (level[j] - level[j + 1]);
    edges.offset_px[k] = band.distance_px[j] + share * band.step_px();
    edges.found[k] = true;
  }
  return edges;
}

/// Returns the standard deviation of one half-level edge of a lamp in ordinary focus. The level
/// between two samples is taken as straight, which holds less well where it is clipped above the
/// edge.
double coarse_sigma_px(const PixelNoise& noise, const Blob& blob) {
  constexpr double kStraight_px = 0.03, kClipped_px = 0.06;
  const double sigma = std::sqrt(noise.variance(0.5 * (blob.level + blob.background)));
  const double least = blob.saturated_share > 0.0 ? kClipped_px : kStraight_px;
  return std::max(least, 2.0 * kOrdinaryBlur_px * sigma / blob.contrast());
}

/// Fits outlines to the edges of one band.
class EdgeFits {
 public:
  EdgeFits(const Normals& normals, const CoarseEdges& edges, double sigma_px)
      : normals_(normals), edges_(edges), sigma_px_(sigma_px) {}

  OutlineFit fit(const NormalFlags& use, double wave_px) const {
    return fit_outline(normals_, edges_.offset_px, information(use), wave_px * wave_px);
  }

  /// Returns the normals that agree with the fit to all but the arc that is best left out.
  NormalFlags without_arc(double wave_px) const {
    const ArcFit arc =
        fit_without_arc(normals_, edges_.offset_px, information(edges_.found), wave_px * wave_px);
    return agreeing(normals_, edges_.offset_px, arc.fit, {sigma_px_, kOrdinaryBlur_px},
                    edges_.found, arc.use);
  }

  /// Returns the mean square of a fit's residuals divided by the edges' variance.
  double scatter(const OutlineFit& fit, const NormalFlags& use) const {
    const PerNormal residual = residuals(fit);
    double squares = 0.0;
    for (Eigen::Index k = 0; k < residual.size(); ++k)
      if (use[k]) squares += residual[k] * residual[k];
    const auto count = static_cast<double>(std::max<Eigen::Index>(1, use.count()));
    return squares / (count * sigma_px_ * sigma_px_);
  }

  /// Returns whether the residuals are no larger than the edges' noise.
  bool explains(const OutlineFit& fit) const {
    constexpr double kMostScatter = 2.5, kMostSigmas = 5.0;
    const PerNormal residual = residuals(fit);
    for (Eigen::Index k = 0; k < residual.size(); ++k)
      if (edges_.found[k] && std::abs(residual[k]) > kMostSigmas * sigma_px_) return false;
    return scatter(fit, edges_.found) < kMostScatter;
  }

 private:
  PerNormal residuals(const OutlineFit& fit) const {
    return edges_.offset_px - normals_.moved(fit.terms);
  }
  PerNormal information(const NormalFlags& use) const {
    return use.cast<double>().matrix() / (sigma_px_ * sigma_px_);
  }

  const Normals& normals_;
  const CoarseEdges& edges_;
  double sigma_px_;
};

}  // namespace

std::optional<CoarseOutlines> find_outlines(const RimBand& band, const Outline& from,
                                            const Blob& blob, const PixelNoise& noise) {
  constexpr double kOrdinaryWave = 0.005, kLargeWave = 0.02;  // per harmonic, of the radius
  constexpr double kClearlyLess = 0.5;
  constexpr double kNeighbours = 2.0;  // neighbouring edges share pixels and err together
  const CoarseEdges edges = half_level_edges(band, blob.contrast());
  if (2 * edges.found.count() < band.normals.count()) return std::nullopt;
  const double radius = 0.5 * from.diameter();
  const EdgeFits fits(band.normals, edges, coarse_sigma_px(noise, blob));
  const auto outline = [&](const OutlineFit& fit, const NormalFlags& use) {
    CoarseOutline coarse{
        from, use,
        kNeighbours * std::max(1.0, fits.scatter(fit, use)) * fit.covariance.topLeftCorner<2, 2>()};
    coarse.outline.change(fit.terms);
    return coarse;
  };
  const OutlineFit even = fits.fit(edges.found, 0.0);
  if (fits.explains(even)) return CoarseOutlines{outline(even, edges.found), std::nullopt};
  const OutlineFit wavy = fits.fit(edges.found, kLargeWave * radius);
  const CoarseOutline bent = outline(wavy, edges.found);
  if (fits.explains(wavy)) return CoarseOutlines{bent, std::nullopt};
  const NormalFlags use = fits.without_arc(kOrdinaryWave * radius);
  const OutlineFit rest = fits.fit(use, kOrdinaryWave * radius);
  if (2 * use.count() > use.size() &&
      fits.scatter(rest, use) < kClearlyLess * fits.scatter(wavy, edges.found))
    return CoarseOutlines{outline(rest, use), bent};
  return CoarseOutlines{bent, std::nullopt};
}

}  // namespace planar
