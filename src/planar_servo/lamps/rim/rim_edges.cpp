#include "planar_servo/lamps/rim/rim_edges.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"

namespace planar {
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

Unknowns unknowns(double dark, double bright, double dark_slope, double bright_slope, double offset,
                  double blur) {
  Unknowns x;
  x << dark, bright, dark_slope, bright_slope, offset, blur;
  return x;
}

Unknowns unknowns(const EdgeProfile& p) {
  return unknowns(p.dark, p.bright, p.dark_slope, p.bright_slope, p.offset_px, p.blur_px);
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

constexpr int kKinds = RimLevels::kKinds, kHarmonics = Normals::kHarmonics;
enum Kind { kDark, kBright, kDarkSlope, kBrightSlope };
using Kinds = Eigen::Matrix<double, kKinds, 1>;
using KindSquare = Eigen::Matrix<double, kKinds, kKinds>;
using HarmonicSquare = Eigen::Matrix<double, kHarmonics, kHarmonics>;
using Templates = Eigen::Matrix<double, kKinds + 1, RimBand::kPlaces>;
/// Templates in single precision, padded to whole SIMD registers.
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
  Templates shapes;
  WideTemplates weighted = WideTemplates::Zero();
  Eigen::Matrix<float, RimBand::kPlaces, 1> bend;  // change of a level by a unit of blur
  for (int j = 0; j < RimBand::kPlaces; ++j) {
    const double d = band.distance_px[j];
    const EdgeShape edge = profile.shape(d);
    const double slope = edge.density / profile.blur_px;
    const double inner_slope = common.is_clipped ? 0.0 : d * edge.share;
    shapes.col(j) << 1.0 - edge.share, edge.share, d * (1.0 - edge.share), inner_slope, slope;
    weighted.col(j).head<kKinds + 1>() = (common.weight[j] * shapes.col(j)).cast<float>();
    bend[j] = static_cast<float>(0.5 * (profile.bright - profile.dark) * slope *
                                 (d - profile.offset_px) / (profile.blur_px * profile.blur_px));
  }
  const Eigen::Matrix<double, kKinds + 1, kKinds + 1> square =
      shapes * common.weight.asDiagonal() * shapes.transpose();

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
  using LevelSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                    RimLevels::kTerms, RimLevels::kTerms>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, RimLevels::kTerms, 1>;
  struct Term {
    int kind, harmonic;
  };
  std::array<Term, RimLevels::kTerms> terms;
  std::size_t n = 0;
  for (int kind = 0; kind < kKinds; ++kind) {
    const int harmonics = varies[static_cast<std::size_t>(kind)] ? kHarmonics : 1;
    for (int h = 0; h < harmonics; ++h) terms[n++] = {kind, h};
  }
  const auto size = static_cast<Eigen::Index>(n);
  LevelSquare normal(size, size);
  Column right(size);
  for (std::size_t i = 0; i < n; ++i) {
    right[static_cast<Eigen::Index>(i)] = equations.right(terms[i].kind, terms[i].harmonic);
    for (std::size_t j = 0; j < n; ++j)
      normal(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          equations.kinds(terms[i].kind, terms[j].kind) *
          equations.harmonics(terms[i].harmonic, terms[j].harmonic);
  }
  const Eigen::LLT<LevelSquare> solver(normal);
  const Column x = solver.solve(right);
  const LevelSquare inverse = solver.solve(LevelSquare::Identity(size, size));
  RimLevels levels{decltype(RimLevels::harmonics)::Zero(), decltype(RimLevels::covariance)::Zero()};
  const auto place = [](const Term& term) { return term.kind * kHarmonics + term.harmonic; };
  for (std::size_t i = 0; i < n; ++i) {
    levels.harmonics(terms[i].kind, terms[i].harmonic) = x[static_cast<Eigen::Index>(i)];
    for (std::size_t j = 0; j < n; ++j)
      levels.covariance(place(terms[i]), place(terms[j])) =
          inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  return levels;
}

/// Returns the kinds that vary round the rim by more than their noise explains. Level and slope of
/// one side are nearly exchangeable and are therefore first tested together.
KindFlags significant_kinds(const LevelEquations& equations, bool is_clipped) {
  constexpr int kWaving = kHarmonics - 1;
  constexpr double kSigmas = 3.0;
  const KindSquare kinds = equations.kinds.inverse();
  const HarmonicSquare harmonics = equations.harmonics.inverse();
  const Eigen::Matrix<double, kKinds, kWaving> x =
      (kinds * equations.right * harmonics).rightCols<kWaving>();
  const Eigen::Matrix<double, kWaving, kWaving> precision =
      harmonics.bottomRightCorner<kWaving, kWaving>().inverse();
  const KindSquare scatter = x * precision * x.transpose();
  const auto limit = [](int freedom) { return freedom + kSigmas * std::sqrt(2.0 * freedom); };
  KindFlags varies{};
  for (const auto& [level, slope] : {std::pair{kDark, kDarkSlope}, {kBright, kBrightSlope}}) {
    if (level == kBright && is_clipped) continue;
    Eigen::Matrix2d covariance, side;
    covariance << kinds(level, level), kinds(level, slope), kinds(slope, level),
        kinds(slope, slope);
    side << scatter(level, level), scatter(level, slope), scatter(slope, level),
        scatter(slope, slope);
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
