#include "marker/rim_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "marker/outline.h"
#include "marker/outline_fit.h"
#include "marker/pixel_noise.h"
#include "marker/rim_band.h"
#include "marker/rim_edges.h"

namespace planar {
namespace {

constexpr double kLeastShare = 0.5;  // of the rim that must agree with its outline
constexpr double kOrdinaryBlur_px = 0.9;

struct CoarseEdges {
  PerNormal offset_px;
  NormalFlags found;
};

/// Where the level half way between both ends of a normal is crossed, seen from outside.
CoarseEdges half_level_edges(const RimBand& band, double contrast) {
  constexpr double kLeastStep = 0.2;
  constexpr int kEnd = 3;
  const Eigen::Index count = band.normals.count(), last = RimBand::kPlaces - 1;
  CoarseEdges edges{PerNormal::Zero(count), NormalFlags::Constant(count, false)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto level = band.level.col(k);
    const double bright = level.head<kEnd>().mean(), dark = level.tail<kEnd>().mean();
    if (bright - dark < kLeastStep * contrast) continue;
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

/// Standard deviation of one half-level edge of a lamp in ordinary focus. The crossing between two
/// samples is taken for straight, which it is less where the light is clipped above it.
double coarse_sigma_px(const PixelNoise& noise, const Blob& blob) {
  constexpr double kStraight_px = 0.03, kClipped_px = 0.06;
  const double sigma = std::sqrt(noise.variance(0.5 * (blob.level + blob.background)));
  const double least = blob.saturated_share > 0.0 ? kClipped_px : kStraight_px;
  return std::max(least, 2.0 * kOrdinaryBlur_px * sigma / blob.contrast());
}

PerNormal informations(const NormalFlags& use, double sigma_px) {
  return use.cast<double>().matrix() / (sigma_px * sigma_px);
}

/// An outline through half-level edges.
struct Start {
  Outline outline;
  NormalFlags use;
  Eigen::Matrix2d center_covariance;  ///< by the scatter of the edges
};

double mean_square(const PerNormal& values, const NormalFlags& use) {
  return values.cwiseProduct(use.cast<double>().matrix()).squaredNorm() /
         static_cast<double>(std::max<Eigen::Index>(1, use.count()));
}

/// Does the fit leave no more than the edges' noise?
bool explains(const OutlineFit& fit, const Normals& normals, const CoarseEdges& edges,
              double sigma_px) {
  constexpr double kMostVariance = 2.5, kMostSigmas = 5.0;
  const PerNormal residual = edges.offset_px - normals.moved(fit.terms);
  double most = 0.0;
  for (Eigen::Index k = 0; k < residual.size(); ++k) {
    if (edges.found[k]) most = std::max(most, std::abs(residual[k]));
  }
  return mean_square(residual, edges.found) < kMostVariance * sigma_px * sigma_px &&
         most < kMostSigmas * sigma_px;
}

/// From the blob's moments to an outline within a few tenths of a pixel: the first that explains
/// the edges, of an ellipse, of one with waves as large as they come, and of one with ordinary
/// waves to all but a quarter of the rim and to what agrees with that. The last only if it leaves
/// clearly less than the one before.
std::optional<Start> find_outline(const RimBand& band, const Outline& from, const Blob& blob,
                                  const PixelNoise& noise) {
  constexpr double kOrdinaryWave = 0.005, kLargeWave = 0.02;  // per harmonic, of the radius
  constexpr double kClearlyLess = 0.5;
  constexpr double kNeighbours = 2.0;  // edges that are wrong together: they share pixels
  const Normals& normals = band.normals;
  const CoarseEdges edges = half_level_edges(band, blob.contrast());
  const auto least = kLeastShare * normals.count();
  if (static_cast<double>(edges.found.count()) < least) return std::nullopt;
  const double sigma = coarse_sigma_px(noise, blob), radius = 0.5 * from.diameter();
  const double large = std::pow(kLargeWave * radius, 2),
               ordinary = std::pow(kOrdinaryWave * radius, 2);
  const auto scatter = [&](const OutlineFit& fit, const NormalFlags& use) {
    return mean_square(edges.offset_px - normals.moved(fit.terms), use);
  };
  Start start{from, edges.found, Eigen::Matrix2d::Zero()};
  const PerNormal information = informations(edges.found, sigma);
  OutlineFit fit = fit_outline(normals, edges.offset_px, information, 0.0);
  if (!explains(fit, normals, edges, sigma)) {
    fit = fit_outline(normals, edges.offset_px, information, large);
  }
  if (!explains(fit, normals, edges, sigma)) {
    const ArcFit arc = fit_without_arc(normals, edges.offset_px, information, ordinary);
    const NormalFlags use = agreeing(normals, edges.offset_px, arc.fit, {sigma, kOrdinaryBlur_px},
                                     edges.found, arc.use);
    const OutlineFit rest =
        fit_outline(normals, edges.offset_px, informations(use, sigma), ordinary);
    if (static_cast<double>(use.count()) > least &&
        scatter(rest, use) < kClearlyLess * scatter(fit, edges.found)) {
      start.use = use;
      fit = rest;
    }
  }
  start.outline.change(fit.terms);
  const double excess = scatter(fit, start.use) / (sigma * sigma);
  start.center_covariance =
      kNeighbours * std::max(1.0, excess) * fit.covariance.topLeftCorner<2, 2>();
  return start;
}

/// Of the centre: by the edges' noise at given levels, and by the levels'.
Eigen::Matrix2d center_covariance(const OutlineFit& fit, const Normals& normals,
                                  const RimEdges& edges) {
  constexpr int kShape = Outline::kShapeTerms;
  Normals::Columns<2> per_offset =
      fit.covariance.topLeftCorner<2, kShape>() * normals.move.topRows<kShape>();
  if (fit.has_waves) {
    per_offset += fit.covariance.topRightCorner<2, Outline::kWaveTerms>() *
                  normals.move.bottomRows<Outline::kWaveTerms>();
  }
  per_offset *= edges.information.asDiagonal();
  Eigen::Matrix<double, 2, RimLevels::kTerms> per_level;
  for (int kind = 0; kind < RimLevels::kKinds; ++kind) {
    per_level.middleCols<Normals::kHarmonics>(kind * Normals::kHarmonics) =
        per_offset * edges.moved_by_level.row(kind).asDiagonal() * normals.harmonics.transpose();
  }
  return fit.covariance.topLeftCorner<2, 2>() +
         per_level * edges.levels.covariance * per_level.transpose();
}

double largest_gap(const NormalFlags& use) {
  const Eigen::Index n = use.size();
  Eigen::Index longest = 0, run = 0;
  for (Eigen::Index k = 0; k < 2 * n && longest < n; ++k) {
    run = use[k % n] ? 0 : run + 1;
    longest = std::max(longest, run);
  }
  return 2.0 * kPi * static_cast<double>(longest) / static_cast<double>(n);
}

/// Is this still the lamp that the blob announced?
bool is_near(const Outline& outline, const Blob& blob) {
  constexpr double kMostShift = 0.25, kMostGrowth = 1.5;  // of the diameter
  const double ratio = outline.diameter() / blob.diameter_px();
  return outline.axes.determinant() > 0.0 && outline.axes.trace() > 0.0 && ratio < kMostGrowth &&
         ratio > 1.0 / kMostGrowth &&
         (outline.center - blob.uv_px).norm() < kMostShift * blob.diameter_px();
}

/// How far inside an outline its normals may be followed: they meet where it is narrow.
double reach_inside_px(const Outline& outline, double wanted_px) {
  constexpr double kMost = 0.75;  // of the minor half axis
  const double half_trace = 0.5 * outline.axes.trace();
  const double minor =
      half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - outline.axes.determinant()));
  return std::min(wanted_px, kMost * minor);
}

/// The band of the first look is as wide as a blob's moments may be wrong.
void sample_coarsely(const cv::Mat& image, const Outline& outline, double reach_px, RimBand& band) {
  constexpr double kReach = 0.35, kLeast_px = 4.0;  // of the radius
  const double reach = std::max(kLeast_px, 0.5 * kReach * outline.diameter());
  band.sample(image, outline, normals_round(outline.diameter()), -reach_inside_px(outline, reach),
              std::min(reach, reach_px));
}

/// One round of the measurement along the normals of an outline.
struct Round {
  OutlineFit fit;
  Eigen::Matrix2d center_covariance;
  NormalFlags use;
  double blur_px;

  /// The rim that was measured is the one that the outline follows.
  bool is_settled(const NormalFlags& used) const {
    constexpr double kNear_px = 0.1;
    return (use == used).all() && fit.terms.head<2>().norm() < kNear_px;
  }
};

std::optional<Round> measure(const cv::Mat& image, const Outline& outline, const PixelNoise& noise,
                             double reach_px, const NormalFlags& use, RimBand& band) {
  constexpr double kReach_px = 6.0;
  band.sample(image, outline, static_cast<int>(use.size()), -reach_inside_px(outline, kReach_px),
              std::min(kReach_px, reach_px));
  const std::optional<RimEdges> edges = measure_edges(band, outline, noise, use);
  if (!edges) return std::nullopt;
  const OutlineFit fit = fit_outline(band.normals, edges->offset_px, edges->information);
  if (!fit.terms.allFinite()) return std::nullopt;
  const double sigma_px = 1.0 / std::sqrt(edges->information.maxCoeff());
  return Round{fit, center_covariance(fit, band.normals, *edges),
               agreeing(band.normals, edges->offset_px, fit, {sigma_px, edges->blur_px},
                        edges->readable, use),
               edges->blur_px};
}

/// From the start in rounds to the rim that is measured by all its pixels.
std::optional<RimFit> refine(const cv::Mat& image, const Blob& blob, const Start& start,
                             const PixelNoise& noise, double reach_px, RimBand& band) {
  constexpr int kRounds = 3;
  Outline outline = start.outline;
  NormalFlags use = start.use;
  RimFit rim;
  for (int i = 0; i < kRounds; ++i) {
    if (!is_near(outline, blob)) return std::nullopt;
    const std::optional<Round> round = measure(image, outline, noise, reach_px, use, band);
    if (!round || static_cast<double>(round->use.count()) < kLeastShare * band.normals.count()) {
      return std::nullopt;
    }
    outline.change(round->fit.terms);
    const bool is_settled = round->is_settled(use);
    use = round->use;
    rim.center_covariance = round->center_covariance;
    // The blur of a bent edge moves it inwards, by half its variance over the radius.
    rim.diameter = outline.diameter() + 2.0 * round->blur_px * round->blur_px / outline.diameter();
    if (is_settled) break;
  }
  if (!is_near(outline, blob)) return std::nullopt;
  rim.center = outline.center;
  rim.largest_gap = largest_gap(use);
  return rim;
}

bool is_measurement(const RimFit& rim) {
  constexpr double kMostSigma_px = 0.25;
  return rim.center_covariance.trace() < 2.0 * kMostSigma_px * kMostSigma_px;
}

}  // namespace

std::optional<RimFit> fit_rim(const cv::Mat& image, const Blob& blob, double reach_px) {
  const Outline outline = outline_of(blob);
  if (!is_near(outline, blob)) return std::nullopt;
  const PixelNoise noise = estimate_noise(image, outline);
  static thread_local RimBand band;  // large, and half of it serves the next lamp of this size
  sample_coarsely(image, outline, reach_px, band);
  const std::optional<Start> start = find_outline(band, outline, blob, noise);
  if (!start) return std::nullopt;
  std::optional<RimFit> rim = refine(image, blob, *start, noise, reach_px, band);
  if (!rim && is_near(start->outline, blob)) {
    rim = RimFit{start->outline.center, start->center_covariance, start->outline.diameter(),
                 largest_gap(start->use)};
  }
  if (rim && !is_measurement(*rim)) rim.reset();
  return rim;
}

}  // namespace planar
