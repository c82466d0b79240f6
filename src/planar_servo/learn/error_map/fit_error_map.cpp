#include "planar_servo/learn/error_map/fit_error_map.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit/outliers.h"
#include "planar_servo/learn/error_map/fit/pair_checks.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "planar_servo/learn/error_map/fit/sparse_fit.h"

namespace planar {
namespace {

constexpr Eigen::Index kFewestForTerms = 20;
constexpr double kSignificance = 3.0;

/// The least rcond of the scaled equations. Below, as in a thin strip, noise alone tells a term.
constexpr double kSmallestRcond = 1e-6;

constexpr double kMicro = 1e-6, kMilli = 1e-3;
constexpr std::array<CellFaultName, kCellFaults> kNames{
    {{"shift x", "shift_x_mm", "mm", kMillimetre},
     {"shift y", "shift_y_mm", "mm", kMillimetre},
     {"scale (plane height)", "scale_um_per_m", "um/m", kMicro},
     {"rotation", "rotation_urad", "urad", kMicro},
     {"x longer than y", "stretch_um_per_m", "um/m", kMicro},
     {"x, y not square", "squareness_urad", "urad", kMicro},
     {"tilt towards x", "tilt_x_mrad_per_m", "mrad/m", kMilli},
     {"tilt towards y", "tilt_y_mrad_per_m", "mrad/m", kMilli},
     {"radial remainder", "radial_mm_per_m3", "mm/m^3", kMilli}}};

using Terms = Eigen::Matrix<double, kCellFaults, 1>;
using Normal = Eigen::Matrix<double, kCellFaults, kCellFaults>;
using Design = Eigen::Matrix<double, 2, kCellFaults>;

Design design_at(const Eigen::Vector2d& u) {
  Design design;
  design << 1.0, 0.0, u.x(), -u.y(), 0.5 * u.x(), 0.5 * u.y(), u.x() * u.x(), u.y() * u.x(),
      u.squaredNorm() * u.x(),  //
      0.0, 1.0, u.y(), u.x(), -0.5 * u.y(), 0.5 * u.x(), u.x() * u.y(), u.y() * u.y(),
      u.squaredNorm() * u.y();
  return design;
}

struct NormalEquations {
  Normal matrix{Normal::Zero()};
  Terms right{Terms::Zero()};

  void add(const Design& design, const Eigen::Vector2d& error, double count) {
    matrix += count * design.transpose() * design;
    right += count * design.transpose() * error;
  }
  std::optional<Terms> solution() const {
    const Terms scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return {};
    const auto scaled = solve_positive(scale.asDiagonal() * matrix * scale.asDiagonal(),
                                       scale.cwiseProduct(right), kSmallestRcond);
    if (!scaled) return {};
    return Terms(scale.cwiseProduct(scaled->col(0)));
  }
};

/// Returns the jackknife's deviations; empty when the terms are undetermined without some block.
std::optional<Terms> jackknife_sigmas(const NormalEquations& all,
                                      const std::vector<NormalEquations>& of_blocks) {
  std::vector<Terms> estimates;
  Terms mean = Terms::Zero();
  const auto count = static_cast<double>(of_blocks.size());
  for (const NormalEquations& block : of_blocks) {
    const NormalEquations rest{all.matrix - block.matrix, all.right - block.right};
    const auto without = rest.solution();
    if (!without) return {};
    estimates.push_back(*without);
    mean += *without / count;
  }
  Terms squares = Terms::Zero();
  for (const Terms& estimate : estimates) squares += (estimate - mean).cwiseAbs2();
  return Terms((squares * (count - 1.0) / count).cwiseSqrt());
}

/// A map fitted to sites, not yet judged.
struct MethodFit {
  ErrorMap map;
  std::vector<Eigen::Index> kept;  ///< sites, in order
  std::vector<Outlier> outliers;
  Eigen::Matrix2Xd residuals;  ///< of the kept sites when each is left out, metres
  Eigen::VectorXd sigmas;      ///< of each residual per axis; see MapPlaces
};

MethodFit method_fit(RobustFit robust) {
  RbfFit& fit = robust.fit;
  Eigen::VectorXd sigmas = fit.map.parameters().signal_sigma * fit.left_out.unit_sigmas;
  return {std::move(fit.map), std::move(robust.kept), std::move(robust.outliers),
          std::move(fit.left_out.residuals), std::move(sigmas)};
}

MethodFit fit_many(const MapSites& sites, const Progress& progress) {
  SparseFit fit = fit_sparse(sites, progress);
  return {std::move(fit.map), std::move(fit.kept), std::move(fit.outliers),
          std::move(fit.residuals), std::move(fit.sigmas)};
}

MethodFit fit_weighted(const MapSites& sites) {
  const IdwMap map = idw_map(sites);
  Eigen::Matrix2Xd residuals = leave_one_out_residuals(map);
  const double sigma = std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
  return {map,
          sites_without({}, sites.size()),
          {},
          std::move(residuals),
          Eigen::VectorXd::Constant(sites.size(), sigma)};
}

MethodFit fit_by_hand(const MapSites& sites, double width) {
  if (!(std::isfinite(width) && width > 0.0))
    throw InputError(
        {fmt::format("the map's width is {} mm", mm(width)), "it must be a positive number"});
  return method_fit({fit_hand_width(sites, width), sites_without({}, sites.size()), {}});
}

/// Fits by the method of `problem` to sites merged of its samples.
MethodFit fit_by_method(const MapSites& sites, const MapProblem& problem,
                        const Progress& progress) {
  if (problem.method != MapMethod::kAuto && sites.size() > kMostDense)
    throw InputError(
        {fmt::format("the pairs have {} distinct positions; the method {} takes at most {}",
                     sites.size(), name_in(kMapMethods, problem.method), kMostDense),
         "leave some out, or use auto"});
  switch (problem.method) {
    case MapMethod::kIdw:
      return fit_weighted(sites);
    case MapMethod::kHandWidth:
      return fit_by_hand(sites, problem.hand_width);
    case MapMethod::kRbf:
      return method_fit(fit_without_outliers(sites, {kOneWidth}));
    case MapMethod::kAuto:
      break;
  }
  if (sites.size() > kMostDense) return fit_many(sites, progress);
  return method_fit(fit_without_outliers(sites, {kManyScales, kSmooth}));
}

/// Samples in groups must outnumber the groups by this share of all samples.
constexpr double kLeastRepeats = 0.2;

/// The samples of a group share a place if they have more than this share of their noise's variance
/// in common, or if without the whole group they are missed by this many times the leave-one-out
/// error. Else they are as good as apart, and averaging them would blur the map.
constexpr double kClearShare = 0.2;
constexpr double kClearMiss = 1.25;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct FitAtPlaces {
  MethodFit fit;
  MapSites sites;
  double place_share{kUnknown};
  std::vector<RejectedSample> rejected;  ///< samples that are in no site

  double loo_rms() const { return sites.subset(fit.kept).sample_rms(fit.residuals); }
};

bool is_tuned(MapMethod method) {
  return method == MapMethod::kAuto || method == MapMethod::kRbf;
}

double count_of_repeats(const MapSites& sites) {
  return sites.counts.sum() - static_cast<double>(sites.size());
}

/// Returns the share of the noise's variance that the samples of a site have in common, if
/// `site_sigma` is the standard deviation per axis of their means.
double place_share(const MapSites& sites, double site_sigma) {
  const double reading2 = sites.scatter.sum() / (2.0 * count_of_repeats(sites));
  const double of_means2 = reading2 * sites.counts.cwiseInverse().mean();
  const double place2 = std::max(0.0, site_sigma * site_sigma - of_means2);
  return place2 > 0.0 ? place2 / (place2 + reading2) : 0.0;
}

/// Returns the sites as if all samples of a site were wrong alike.
MapSites all_alike(MapSites sites) {
  sites.place_share = 1.0;
  sites.stated_sigma *= std::sqrt(sites.counts.cwiseInverse().mean());
  return sites;
}

/// Fits twice where the method finds the noise: at first as if all samples of a site were wrong
/// alike, which tells the noise of their means, and then with the share that follows from it.
FitAtPlaces fit_at_places(MapSites sites, const MapProblem& problem, const Progress& progress) {
  double share = kUnknown;
  if (is_tuned(problem.method) && count_of_repeats(sites) > 0.0) {
    share = place_share(sites, noise_sigma(fit_by_method(all_alike(sites), problem, progress).map));
    sites.place_share = share;
  }
  MethodFit fit = fit_by_method(sites, problem, progress);
  return {std::move(fit), std::move(sites), share, {}};
}

RejectedSample rejected_sample(const Outlier& outlier, std::size_t index,
                               const std::vector<ErrorSample>& samples, const char* by) {
  return {{samples[index].id, fmt::format("{:.4f} mm from {}, where {:.4f} mm is allowed",
                                          mm(outlier.residual), by, mm(outlier.limit))},
          index,
          outlier.residual};
}

/// Fits to the samples that agree with the others of their place.
FitAtPlaces fit_to_agreeing(const MapProblem& problem, const Progress& progress) {
  const std::vector<ErrorSample>& samples = problem.samples;
  std::vector<bool> used(samples.size(), true);
  std::vector<RejectedSample> rejected;
  for (const auto& [index, outlier] : samples_unlike_their_place(samples, merge_samples(samples))) {
    const auto i = static_cast<std::size_t>(index);
    used[i] = false;
    rejected.push_back(rejected_sample(outlier, i, samples, "the other pairs of its place"));
  }
  FitAtPlaces fit = fit_at_places(merge_samples(samples, used), problem, progress);
  fit.rejected = std::move(rejected);
  return fit;
}

/// Fits to the places that the positions show; empty if they show none.
std::optional<FitAtPlaces> fit_at_found_places(const MapProblem& problem, const MapSites& sites,
                                               const Progress& progress) {
  if (!is_tuned(problem.method)) return {};
  const MapProblem with_places{with_found_places(problem.samples, sites), problem.method,
                               problem.hand_width};
  const double repeats = count_of_repeats(merge_samples(with_places.samples));
  if (repeats < kLeastRepeats * static_cast<double>(problem.samples.size())) return {};
  return fit_to_agreeing(with_places, progress);
}

/// Returns the standard deviation of the rounding with which the errors were written, metres: the
/// step is that of the last decimal of millimetres that any of them has.
double rounding_sigma(const std::vector<ErrorSample>& samples) {
  constexpr int kMostDecimals = 8;
  const bool any = std::any_of(samples.begin(), samples.end(),
                               [](const ErrorSample& sample) { return sample.error.norm() > 0.0; });
  if (!any) return 0.0;
  const auto fits = [&](double step_m) {
    const auto on_step = [&](double value) {
      constexpr double kRounding = 1e-3;  // of a step, to allow for binary fractions
      return std::abs(value / step_m - std::round(value / step_m)) < kRounding;
    };
    return std::all_of(samples.begin(), samples.end(), [&](const ErrorSample& sample) {
      return on_step(sample.error.x()) && on_step(sample.error.y());
    });
  };
  for (int decimals = 0; decimals <= kMostDecimals; ++decimals)
    if (const double step_m = kMillimetre * std::pow(10.0, -decimals); fits(step_m))
      return step_m / std::sqrt(12.0);
  return 0.0;
}

double coverage_95(const MapPlaces& at) {
  int within = 0;
  for (Eigen::Index i = 0; i < at.residuals.cols(); ++i)
    within += components_within_95(at.residuals.col(i), Eigen::Vector2d::Constant(at.sigmas[i]));
  return within / (2.0 * static_cast<double>(at.residuals.cols()));
}

MapResult judged(FitAtPlaces at, PlaceSource places, const std::vector<ErrorSample>& samples,
                 const Progress& progress) {
  tell(progress, "judging the map", 0, 1);
  const MapSites used = at.sites.subset(at.fit.kept);
  MapResult result;
  result.map = std::move(at.fit.map);
  result.n_used = static_cast<std::size_t>(used.counts.sum());
  result.places = places;
  result.n_places = static_cast<std::size_t>(used.size());
  result.at_places = {used.positions, used.errors, at.fit.residuals,
                      at.fit.sigmas.cwiseMax(rounding_sigma(samples))};
  result.coverage_95 = coverage_95(result.at_places);
  result.rejected = std::move(at.rejected);
  for (const Outlier& outlier : at.fit.outliers)
    for (const std::size_t i : at.sites.samples[static_cast<std::size_t>(outlier.site)])
      result.rejected.push_back(
          rejected_sample(outlier, i, samples, "what the other pairs predict there"));
  result.raw_rms = used.sample_rms(used.errors);
  result.loo_rms = used.sample_rms(at.fit.residuals);
  result.idw_loo_rms = used.size() <= kMostDense
                           ? used.sample_rms(leave_one_out_residuals(idw_map(used)))
                           : kUnknown;
  result.noise_sigma = noise_sigma(result.map);
  result.place_share = at.place_share;
  const CrossValidation validation = cross_validate(result.map, used);
  result.blocked = validation.rms;
  result.gap = validation.gap;
  result.worth_using = is_worth_using(used, at.fit.residuals);
  result.cell = diagnose_cell(used);
  return result;
}

}  // namespace

const CellFaultName& name_of(CellFault fault) {
  return kNames[static_cast<std::size_t>(fault)];
}

CellDiagnosis diagnose_cell(const MapSites& sites) {
  if (sites.size() < kFewestForTerms) return {};
  const Eigen::Vector2d middle = sites.positions.rowwise().mean();
  NormalEquations all;
  std::vector<NormalEquations> of_blocks;
  for (const auto& block : spatial_blocks(sites.positions)) {
    NormalEquations& sums = of_blocks.emplace_back();
    for (const Eigen::Index i : block)
      sums.add(design_at(sites.positions.col(i) - middle), sites.errors.col(i), sites.counts[i]);
    all.matrix += sums.matrix;
    all.right += sums.right;
  }
  const auto values = all.solution();
  const auto sigmas = jackknife_sigmas(all, of_blocks);
  if (!values || !sigmas) return {};
  CellDiagnosis diagnosis;
  for (int k = 0; k < kCellFaults; ++k) {
    const double value = (*values)[k], sigma = (*sigmas)[k];
    const double rms = std::abs(value) * std::sqrt(all.matrix(k, k) / sites.counts.sum());
    diagnosis.terms.push_back(
        {static_cast<CellFault>(k), value, sigma, rms, std::abs(value) > kSignificance * sigma});
  }
  Eigen::Matrix2Xd left = sites.errors;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    left.col(i) -= design_at(sites.positions.col(i) - middle) * *values;
  diagnosis.left_rms = sites.sample_rms(left);
  return diagnosis;
}

MapResult fit_error_map(const MapProblem& problem, const Progress& progress) {
  const auto result_of = [&](FitAtPlaces fit, PlaceSource places) {
    return judged(std::move(fit), places, problem.samples, progress);
  };
  MapSites sites = merge_samples(problem.samples);
  require_one_unit(sites.positions, sites.positions - sites.errors);
  require_live_tracker(problem.samples);
  if (names_places(problem.samples)) {
    require_narrow_places(problem.samples, sites);
    return result_of(fit_to_agreeing(problem, progress), PlaceSource::kNamed);
  }
  auto together = fit_at_found_places(problem, sites, progress);
  if (together && together->place_share > kClearShare)
    return result_of(*std::move(together), PlaceSource::kFound);
  MethodFit fit = fit_by_method(sites, problem, progress);
  FitAtPlaces apart{std::move(fit), std::move(sites), kUnknown, {}};
  if (together && together->loo_rms() > kClearMiss * apart.loo_rms())
    return result_of(*std::move(together), PlaceSource::kFound);
  return result_of(std::move(apart), PlaceSource::kPositions);
}

}  // namespace planar
