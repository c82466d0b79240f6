#include "planar_servo/lamps/rim/rim_fit.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/rim/outline.h"

namespace planar {

namespace {

/// An outline through half-level edges, correct to a few tenths of a pixel.
struct CoarseOutline {
  Outline outline;
  NormalFlags use;                    ///< the normals whose edges lie on it
  Eigen::Matrix2d center_covariance;  ///< from the scatter of the edges
};

/// The outlines that half-level edges allow. They cannot tell a covered rim from a bent one that is
/// unevenly lit.
struct CoarseOutlines {
  CoarseOutline likely;
  std::optional<CoarseOutline> bent;  ///< through all edges, where `likely` leaves some out
};

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

/// Fits outlines to the half-level edges in a band that was sampled along `from`. The first one
/// that explains them is likely: an ellipse, then an ellipse with large waves. If neither does, an
/// outline with ordinary waves is fitted to all but a quarter of the rim and to what agrees with
/// that; it is likely if its residuals are clearly smaller than those of the one with large waves.
/// Empty when less than half of the rim has edges.
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

/// Returns the covariance of the centre: that of the edges' noise at given levels plus that of the
/// levels.
Eigen::Matrix2d center_covariance(const OutlineFit& fit, const Normals& normals,
                                  const RimEdges& edges) {
  const int terms = fit.has_waves ? Outline::kTerms : Outline::kShapeTerms;
  Eigen::Matrix<double, 2, RimLevels::kTerms> per_level =
      Eigen::Matrix<double, 2, RimLevels::kTerms>::Zero();
  for (int k = 0; k < normals.count(); ++k) {
    const Eigen::Vector2d per_offset =
        edges.information[k] *
        fit.covariance.topLeftCorner(2, terms).lazyProduct(normals.move.col(k).head(terms));
    for (int kind = 0; kind < RimLevels::kKinds; ++kind) {
      per_level.middleCols<Normals::kHarmonics>(Eigen::Index{kind} * Normals::kHarmonics) +=
          (edges.moved_by_level(kind, k) * per_offset) * normals.harmonics.col(k).transpose();
    }
  }
  const decltype(per_level) weighted = per_level.lazyProduct(edges.levels.covariance);
  return fit.covariance.topLeftCorner<2, 2>() + weighted.lazyProduct(per_level.transpose());
}

/// Returns the covariance that the ends of what was left out add, because they may be mistaken for
/// waves of the rim: the square of how far the centre moves when they are left out as well. Not a
/// number where too little of the rim is then left.
Eigen::Matrix2d covariance_of_ends(const OutlineFit& fit, const Normals& normals,
                                   const RimEdges& edges, const NormalFlags& use) {
  if (use.all()) return Eigen::Matrix2d::Zero();
  const NormalFlags inner = clear_of_others(normals, use, edges.blur_px);
  const OutlineFit without_ends = fit_outline(
      normals, edges.offset_px, edges.information.cwiseProduct(inner.cast<double>().matrix()));
  const Eigen::Vector2d moved = without_ends.terms.head<2>() - fit.terms.head<2>();
  return moved * moved.transpose();
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

/// Returns whether the outline is still that of the blob's lamp.
bool is_near(const Outline& outline, const Blob& blob) {
  constexpr double kMostShift = 0.25, kMostGrowth = 1.5;  // of the diameter
  const double ratio = outline.diameter() / blob.diameter_px();
  return outline.axes.determinant() > 0.0 && outline.axes.trace() > 0.0 && ratio < kMostGrowth &&
         ratio > 1.0 / kMostGrowth &&
         (outline.center - blob.uv_px).norm() < kMostShift * blob.diameter_px();
}

/// Returns how far inside an outline its normals may be followed before they meet.
double reach_inside_px(const Outline& outline, double wanted_px) {
  constexpr double kMost = 0.75;  // of the minor half axis
  const double half_trace = 0.5 * outline.axes.trace();
  const double minor =
      half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - outline.axes.determinant()));
  return std::min(wanted_px, kMost * minor);
}

/// Samples a band that is as wide as a blob's moments may be wrong.
void sample_coarsely(const cv::Mat& image, const Outline& outline, double reach_px, RimBand& band) {
  constexpr double kGrowth = 0.35, kLeast_px = 4.0;  // of the radius
  const double reach = std::max(kLeast_px, 0.5 * kGrowth * outline.diameter());
  band.sample(image, outline, normals_round(outline.diameter()), -reach_inside_px(outline, reach),
              std::min(reach, reach_px));
}

/// The result of one round of the measurement along an outline's normals.
struct Round {
  OutlineFit fit;
  double scatter;  ///< mean square of the residuals of all normals divided by their variance
  Eigen::Matrix2d center_covariance, doubt;
  NormalFlags use;
  double blur_px;

  /// Returns whether the outline and the normals in use have stopped changing.
  bool is_settled(const NormalFlags& used) const {
    constexpr double kNear_px = 0.1;
    return (use == used).all() && fit.terms.head<2>().norm() < kNear_px;
  }
};

std::optional<Round> measure(const cv::Mat& image, const Outline& outline, const PixelNoise& noise,
                             double reach_px, const NormalFlags& use, RimBand& band) {
  // A lamp's light changes slowly, but anything may lie around it, so less of the outside is used.
  constexpr double kInside_px = 6.0, kOutside_px = 4.5;
  band.sample(image, outline, static_cast<int>(use.size()), -reach_inside_px(outline, kInside_px),
              std::min(kOutside_px, reach_px));
  const std::optional<RimEdges> edges = measure_edges(band, outline, noise, use);
  if (!edges) return std::nullopt;
  const OutlineFit fit = fit_outline(band.normals, edges->offset_px, edges->information);
  if (!fit.terms.allFinite()) return std::nullopt;
  const double sigma_px = 1.0 / std::sqrt(edges->information.maxCoeff());
  const PerNormal residual = edges->offset_px - band.normals.moved(fit.terms);
  const double scatter = edges->information.dot(residual.cwiseAbs2()) / band.normals.count();
  return Round{fit,
               scatter,
               center_covariance(fit, band.normals, *edges),
               covariance_of_ends(fit, band.normals, *edges, use),
               agreeing(band.normals, edges->offset_px, fit, {sigma_px, edges->blur_px},
                        edges->readable, use),
               edges->blur_px};
}

/// An outline along whose normals the levels were measured.
struct Refined {
  RimFit rim;           ///< its covariance is that of the noise alone
  double scatter{0.0};  ///< as in Round
  /// Covariance of what the rim's shape leaves open.
  Eigen::Matrix2d doubt{Eigen::Matrix2d::Zero()};

  /// Returns whether noise alone leaves a measurement; doubt only widens the stated covariance.
  bool is_measurement() const {
    constexpr double kMostSigma_px = 0.25;
    return rim.center_covariance.trace() < 2.0 * kMostSigma_px * kMostSigma_px && doubt.allFinite();
  }

  /// Returns whether nearly the whole rim is where the outline has it.
  bool is_whole() const {
    constexpr double kMostGap = 20.0 * kDegree, kMostScatter = 3.0;
    return rim.largest_gap < kMostGap && scatter < kMostScatter;
  }
};

/// Repeats the measurement from the start until the outline settles.
std::optional<Refined> refine(const cv::Mat& image, const Blob& blob, const CoarseOutline& start,
                              const PixelNoise& noise, double reach_px, RimBand& band) {
  constexpr int kRounds = 3;
  Outline outline = start.outline;
  NormalFlags use = start.use;
  Refined refined;
  RimFit& rim = refined.rim;
  for (int i = 0; i < kRounds; ++i) {
    if (!is_near(outline, blob)) return std::nullopt;
    const std::optional<Round> round = measure(image, outline, noise, reach_px, use, band);
    if (!round || 2 * round->use.count() < band.normals.count()) return std::nullopt;
    outline.change(round->fit.terms);
    const bool is_settled = round->is_settled(use);
    use = round->use;
    refined.scatter = round->scatter;
    refined.doubt = round->doubt;
    rim.center_covariance = round->center_covariance;
    rim.blur_px = round->blur_px;
    // The blur of a bent edge moves it inwards by half its variance divided by the radius.
    rim.diameter = outline.diameter() + 2.0 * round->blur_px * round->blur_px / outline.diameter();
    if (is_settled) break;
  }
  if (!is_near(outline, blob)) return std::nullopt;
  rim.center = outline.center;
  rim.largest_gap = largest_gap(use);
  return refined;
}

/// Returns the covariance that doubt adds to the centre of a bent rim. It is zero where the outline
/// of the rim's better part agrees on the centre, or is too short for a measurement; otherwise the
/// rim may be cut instead, and the distance of the centres counts as a standard deviation.
Eigen::Matrix2d covariance_of_doubt(const Refined& bent, const Refined& cut) {
  constexpr double kSigmas = 4.5;
  if (!cut.is_measurement()) return Eigen::Matrix2d::Zero();
  const Eigen::Vector2d apart = bent.rim.center - cut.rim.center;
  const Eigen::Matrix2d covariance = cut.rim.center_covariance + cut.doubt;
  const bool agree = apart.dot(covariance.inverse() * apart) < kSigmas * kSigmas;
  if (agree) return Eigen::Matrix2d::Zero();
  return apart * apart.transpose();
}

/// Refines the likely outline, or the bent one where only that is the whole rim.
std::optional<Refined> refine_either(const cv::Mat& image, const Blob& blob,
                                     const CoarseOutlines& starts, const PixelNoise& noise,
                                     double reach_px, RimBand& band) {
  auto likely = refine(image, blob, starts.likely, noise, reach_px, band);
  if (starts.bent && !(likely && likely->is_whole())) {
    auto bent = refine(image, blob, *starts.bent, noise, reach_px, band);
    if (bent && bent->is_whole()) {
      if (likely) bent->doubt += covariance_of_doubt(*bent, *likely);
      return bent;
    }
  }
  return likely;
}

}  // namespace

std::optional<RimFit> fit_rim(const cv::Mat& image, const Blob& blob, double reach_px) {
  const Outline outline = outline_of(blob);
  if (!is_near(outline, blob)) return std::nullopt;
  const PixelNoise noise = estimate_noise(image, outline);
  static thread_local RimBand band;  // large; half of it serves the next lamp of this size
  sample_coarsely(image, outline, reach_px, band);
  const std::optional<CoarseOutlines> starts = find_outlines(band, outline, blob, noise);
  if (!starts) return std::nullopt;
  std::optional<Refined> found = refine_either(image, blob, *starts, noise, reach_px, band);
  const CoarseOutline& start = starts->likely;
  if (!found && is_near(start.outline, blob)) {
    found.emplace();
    found->rim = {start.outline.center, start.center_covariance, start.outline.diameter(), 0.0,
                  largest_gap(start.use)};
  }
  if (!found || !found->is_measurement()) return std::nullopt;
  found->rim.center_covariance += found->doubt;
  return found->rim;
}

namespace {

/// The light of a blurred straight edge at x standard deviations outside it: its share of the full
/// light, and minus the slope of that share.
struct EdgeShape {
  double share, density;
};

EdgeShape edge_shape(double x) {
  constexpr double kRootHalf = 0.70710678118654752, kPeak = 0.39894228040143268;
  return {0.5 * std::erfc(kRootHalf * x), kPeak * std::exp(-0.5 * x * x)};
}

/// Grey levels across a rim at the distance d outside it: a step blurred by a Gaussian between two
/// lines, dark + dark_slope d outside and bright + bright_slope d inside.
struct EdgeProfile {
  double dark{0.0}, bright{0.0}, dark_slope{0.0}, bright_slope{0.0};
  double offset_px{0.0};  ///< of the step
  double blur_px{0.9};    ///< standard deviation

  EdgeShape shape(double d) const { return edge_shape((d - offset_px) / blur_px); }
};

constexpr int kUnknowns = 6;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

Unknowns unknowns(const EdgeProfile& p) {
  return {p.dark, p.bright, p.dark_slope, p.bright_slope, p.offset_px, p.blur_px};
}

/// Fits the profile to levels at distances, from `start`. A weight is the inverse variance of a
/// level, or 0. Parameters that the levels do not determine, such as the bright side of a clipped
/// lamp, stay near `start`.
EdgeProfile fit_edge_profile(const RimBand::Places& distance_px, const RimBand::Places& level,
                             const RimBand::Places& weight, const EdgeProfile& start) {
  constexpr int kSteps = 2;
  constexpr double kLeastBlur_px = 0.4, kMostBlur_px = 4.0;
  // These are the standard deviations of the prior.
  constexpr double kOffset_px = 1.0, kBlur_px = 0.5, kSlope = 0.05;
  const double contrast = start.bright - start.dark;
  const Unknowns sigma(contrast, contrast, kSlope * contrast, kSlope * contrast, kOffset_px,
                       kBlur_px);
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
      const Unknowns row(1.0 - edge.share, edge.share, d * (1.0 - edge.share), d * edge.share,
                         slope, slope * (d - profile.offset_px) / profile.blur_px);
      information.noalias() += weight[j] * row * row.transpose();
      right += weight[j] * (level[j] - dark - step * edge.share) * row;
    }
    solve_positive_in_place(information, right);
    const Unknowns x = unknowns(profile) + right;
    profile = {x[0], x[1], x[2], x[3], x[4], std::clamp(x[5], kLeastBlur_px, kMostBlur_px)};
  }
  return profile;
}

constexpr int kKinds = RimLevels::kKinds, kHarmonics = Normals::kHarmonics;
enum Kind { kDark, kBright, kDarkSlope, kBrightSlope };
using Kinds = Eigen::Matrix<double, kKinds, 1>;
using KindSquare = Eigen::Matrix<double, kKinds, kKinds>;
using HarmonicSquare = Eigen::Matrix<double, kHarmonics, kHarmonics>;
/// Templates of all places in single precision, padded to whole SIMD registers.
using WideTemplates = Eigen::Matrix<float, 8, RimBand::kPlaces>;

/// The mean profile of all normals, which each of them is compared with.
struct CommonProfile {
  EdgeProfile profile;
  RimBand::Places weight;  ///< 1 / variance per normal of mean arc; 0 where clipped
  bool is_clipped{false};
};

/// Returns the first place that is clipped on no normal in use. A few clipped samples outside the
/// ones where many are (a hot pixel) do not count.
int first_unclipped(const RimBand& band, const NormalFlags& use) {
  constexpr double kMany = 0.3;
  if (band.level.maxCoeff() < RimBand::kClipped) return 0;
  const auto clipped = [&](int place) {
    return ((band.level.row(place).transpose().array() == RimBand::kClipped) && use).count();
  };
  int first = 0;
  for (int j = 0; j < RimBand::kPlaces; ++j)
    if (static_cast<double>(clipped(j)) > kMany * static_cast<double>(use.count())) first = j + 1;
  while (first > 0 && first < RimBand::kPlaces && clipped(first) > 0) ++first;
  return first;
}

std::optional<CommonProfile> common_profile(const RimBand& band, const PixelNoise& noise,
                                            const NormalFlags& use) {
  constexpr int kLeastPlaces = 6;
  constexpr double kClippedBright = 300.0;
  const int first = first_unclipped(band, use);
  if (RimBand::kPlaces - first < kLeastPlaces) return std::nullopt;
  CommonProfile common;
  common.is_clipped = first > 0;
  const auto used = static_cast<double>(use.count());
  const RimBand::Places mean =
      (band.level * use.cast<float>().matrix()).cast<double>() / std::max(1.0, used);
  const double arc_px = band.normals.arc_px.mean();
  const double radius_px = arc_px * band.normals.count() / (2.0 * kPi);
  common.weight.setZero();
  for (int j = first; j < RimBand::kPlaces; ++j) {
    const double area_px2 = arc_px * band.step_px() * (1.0 + band.distance_px[j] / radius_px);
    common.weight[j] = area_px2 / noise.variance(mean[j]);
  }
  EdgeProfile start;
  start.dark = mean[RimBand::kPlaces - 1];
  start.bright = common.is_clipped ? kClippedBright : mean[0];
  common.profile = fit_edge_profile(band.distance_px, mean, common.weight * used, start);
  return common;
}

/// Returns the normals that have no clipped sample besides those that are clipped on all.
NormalFlags readable(const RimBand& band, const CommonProfile& common) {
  NormalFlags flags = NormalFlags::Constant(band.normals.count(), true);
  if (band.level.maxCoeff() < RimBand::kClipped) return flags;
  for (Eigen::Index k = 0; k < flags.size(); ++k) {
    for (int j = 0; j < RimBand::kPlaces; ++j)
      if (common.weight[j] > 0.0 && band.level(j, k) == RimBand::kClipped) flags[k] = false;
  }
  return flags;
}

/// The products of the templates with one another and with the levels of each normal. There is one
/// template per kind of level and one for the edge's offset times the contrast.
struct Products {
  KindSquare kinds;        ///< with the offset eliminated
  Kinds offset_per_level;  ///< what a level beside the rim adds to the offset times the contrast
  double offset_information;
  Normals::Columns<kKinds> normal_kinds;  ///< with the offset eliminated
  PerNormal normal_offset;                ///< multiplied by the contrast
};

Products products(const RimBand& band, const CommonProfile& common) {
  const EdgeProfile& profile = common.profile;
  Eigen::Matrix<double, kKinds + 1, kKinds + 1> square = decltype(square)::Zero();
  WideTemplates weighted = WideTemplates::Zero();
  Eigen::Matrix<float, RimBand::kPlaces, 1> bend;  // change of a level by a unit of blur
  for (int j = 0; j < RimBand::kPlaces; ++j) {
    const double d = band.distance_px[j];
    const EdgeShape edge = profile.shape(d);
    const double slope = edge.density / profile.blur_px;
    const double inner_slope = common.is_clipped ? 0.0 : d * edge.share;
    const Eigen::Matrix<double, kKinds + 1, 1> shape(1.0 - edge.share, edge.share,
                                                     d * (1.0 - edge.share), inner_slope, slope);
    weighted.col(j).head<kKinds + 1>() = (common.weight[j] * shape).cast<float>();
    square.noalias() += common.weight[j] * shape * shape.transpose();
    bend[j] = static_cast<float>(0.5 * (profile.bright - profile.dark) * slope *
                                 (d - profile.offset_px) / (profile.blur_px * profile.blur_px));
  }
  Products p;
  p.offset_information = square(kKinds, kKinds);
  const Kinds mixed = square.topRightCorner<kKinds, 1>();
  p.offset_per_level = -mixed / p.offset_information;
  p.kinds = square.topLeftCorner<kKinds, kKinds>() + mixed * p.offset_per_level.transpose();
  p.kinds.diagonal().array() += 1e-9 * p.kinds.trace();  // for a kind left undetermined
  const int count = band.normals.count();
  p.normal_offset.resize(count);
  p.normal_kinds.resize(kKinds, count);
  for (int k = 0; k < count; ++k) {
    const Eigen::Matrix<float, RimBand::kPlaces, 1> level =
        band.level.col(k) - bend.cwiseProduct(band.blur_px2.col(k));
    const Eigen::Matrix<float, WideTemplates::RowsAtCompileTime, 1> sums =
        weighted.lazyProduct(level);
    p.normal_offset[k] = sums[kKinds] / p.offset_information;
    p.normal_kinds.col(k) = sums.head<kKinds>().cast<double>() - mixed * p.normal_offset[k];
  }
  return p;
}

/// The normal equations of the levels' harmonics, as a Kronecker product of kinds and harmonics,
/// when every kind has every harmonic.
struct LevelEquations {
  KindSquare kinds;
  HarmonicSquare harmonics;
  Eigen::Matrix<double, kKinds, kHarmonics> right;
};

using KindFlags = std::array<bool, kKinds>;

/// Solves with the constant of every kind, and with the harmonics of those kinds only that vary.
RimLevels solve(const LevelEquations& equations, const KindFlags& varies) {
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               RimLevels::kTerms, RimLevels::kTerms + 1>;
  struct Term {
    int kind, harmonic;
  };
  std::array<Term, RimLevels::kTerms> terms;
  Eigen::Index n = 0;
  for (int kind = 0; kind < kKinds; ++kind) {
    const int harmonics = varies[static_cast<std::size_t>(kind)] ? kHarmonics : 1;
    for (int h = 0; h < harmonics; ++h) terms[n++] = {kind, h};
  }
  Square normal(n, n), solution(n, n + 1);  // of the levels, then of their covariance
  solution.rightCols(n).setIdentity();
  for (Eigen::Index i = 0; i < n; ++i) {
    solution(i, 0) = equations.right(terms[i].kind, terms[i].harmonic);
    for (Eigen::Index j = 0; j < n; ++j)
      normal(i, j) = equations.kinds(terms[i].kind, terms[j].kind) *
                     equations.harmonics(terms[i].harmonic, terms[j].harmonic);
  }
  solve_positive_in_place(normal, solution);
  RimLevels levels{decltype(RimLevels::harmonics)::Zero(), decltype(RimLevels::covariance)::Zero()};
  const auto place = [](const Term& term) { return term.kind * kHarmonics + term.harmonic; };
  for (Eigen::Index i = 0; i < n; ++i) {
    levels.harmonics(terms[i].kind, terms[i].harmonic) = solution(i, 0);
    for (Eigen::Index j = 0; j < n; ++j)
      levels.covariance(place(terms[i]), place(terms[j])) = solution(i, j + 1);
  }
  return levels;
}

/// Returns the kinds that vary round the rim by more than their noise explains. Level and slope of
/// one side are nearly exchangeable and are therefore first tested together.
KindFlags significant_kinds(const LevelEquations& equations, bool is_clipped) {
  constexpr int kWaving = kHarmonics - 1;
  constexpr double kSigmas = 3.0;
  const KindSquare kinds = inverse_of_positive(equations.kinds);
  const HarmonicSquare harmonics = inverse_of_positive(equations.harmonics);
  const Eigen::Matrix<double, kKinds, kWaving> x =
      (kinds * equations.right * harmonics).rightCols<kWaving>();
  const Eigen::Matrix<double, kWaving, kWaving> precision =
      inverse_of_positive<kWaving>(harmonics.bottomRightCorner<kWaving, kWaving>());
  const KindSquare scatter = x * precision * x.transpose();
  const auto limit = [](int freedom) { return freedom + kSigmas * std::sqrt(2.0 * freedom); };
  KindFlags varies{};
  for (const auto& [level, slope] : {std::pair{kDark, kDarkSlope}, {kBright, kBrightSlope}}) {
    if (level == kBright && is_clipped) continue;
    const std::array<int, 2> both{level, slope};
    const Eigen::Matrix2d covariance = kinds(both, both), side = scatter(both, both);
    if (covariance.inverse().cwiseProduct(side).sum() < limit(2 * kWaving)) continue;
    varies[level] = true;
    varies[slope] = scatter(slope, slope) / kinds(slope, slope) > limit(kWaving);
  }
  return varies;
}

RimLevels fit_levels(const Products& p, const Normals& normals, const PerNormal& weight,
                     bool is_clipped) {
  LevelEquations equations{p.kinds, HarmonicSquare::Zero(),
                           decltype(LevelEquations::right)::Zero()};
  for (int k = 0; k < normals.count(); ++k) {
    const Eigen::Matrix<double, 1, kHarmonics> harmonics = normals.harmonics.col(k).transpose();
    const Eigen::Matrix<double, 1, kHarmonics> weighted = weight[k] * harmonics;
    equations.harmonics.noalias() += harmonics.transpose() * weighted;
    equations.right.noalias() += p.normal_kinds.col(k) * weighted;
  }
  return solve(equations, significant_kinds(equations, is_clipped));
}

}  // namespace

std::optional<RimEdges> measure_edges(const RimBand& band, const Outline& outline,
                                      const PixelNoise& noise, const NormalFlags& use) {
  constexpr double kLeastLocalContrast = 0.1;  // of the mean contrast
  const Normals& normals = band.normals;
  const std::optional<CommonProfile> common = common_profile(band, noise, use);
  if (!common) return std::nullopt;
  RimEdges edges;
  edges.blur_px = common->profile.blur_px;
  edges.readable = readable(band, *common);
  const Products p = products(band, *common);
  const PerNormal weight =
      normals.arc_px.cwiseProduct((use && edges.readable).cast<double>().matrix()) /
      normals.arc_px.mean();
  edges.levels = fit_levels(p, normals, weight, common->is_clipped);
  const double least = kLeastLocalContrast * (common->profile.bright - common->profile.dark);
  edges.moved_by_level.resize(kKinds, normals.count());
  edges.offset_px = normals.waves(outline);
  edges.information = p.offset_information * weight;
  for (int k = 0; k < normals.count(); ++k) {
    const Kinds level = edges.levels.harmonics * normals.harmonics.col(k);
    const double contrast = std::max(least, level[kBright] - level[kDark]);
    edges.moved_by_level.col(k) = p.offset_per_level / contrast;
    edges.offset_px[k] +=
        common->profile.offset_px + (p.normal_offset[k] + p.offset_per_level.dot(level)) / contrast;
    edges.information[k] *= contrast * contrast;
  }
  return edges;
}

}  // namespace planar
