#include "planar_servo/learn/error_map/fit/rbf_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlopt.hpp>
#include <optional>
#include <utility>

#include "planar_servo/base/core/threads.h"
#include "planar_servo/learn/error_map/error_sample.h"

namespace planar {
namespace {

constexpr Eigen::Index kLargestPart = 500;

// These bound the search. A kernel narrower than half the samples' spacing reaches no neighbour;
// one wider than their span is a polynomial.
constexpr double kNarrowestInSpacings = 0.5;
const double kLogSmallestRidge = std::log(1e-10);
const double kLogLargestRidge = std::log(1e3);

/// The grid is searched on a part of the sites, because the time grows with their cube.
constexpr Eigen::Index kRoughPart = 100;
constexpr std::size_t kGridWidths = 8;
constexpr std::size_t kGridRidges = 7;  ///< 1e-7 ... 1e-1
const double kRidgeStep = std::log(10.0);

double grid_log_ridge(std::size_t i) {
  return kRidgeStep * (static_cast<double>(i) - kGridRidges);
}

/// A smaller ridge is taken only if it brings the error below this fraction of the larger one's.
constexpr double kSame = 0.99;

constexpr int kLocalEvaluations = 30;
constexpr double kLogTolerance = 0.03;  // of width and ridge; the error is flat about its minimum

/// Computes r_i = w_i / (A^-1)_ii for the bordered matrix A and its weights w [Rippa 1999].
LeaveOneOut leave_one_out(const BorderedSystem& system, const Eigen::Matrix2Xd& weights) {
  const Eigen::ArrayXd diagonal = system.inverse_diagonal();
  return {(weights.array().rowwise() / diagonal.transpose()).matrix(), diagonal.rsqrt()};
}

/// Returns s_f^2 = E^T w / (N - m) per axis over all N samples, for the weights of a fit whose tail
/// has m terms. Samples averaged at a site scatter about it with variance ridge s_f^2; where they
/// share a part of their noise, only sites count.
double signal_variance(const MapSites& sites, const Eigen::Matrix2Xd& weights, Eigen::Index terms,
                       double ridge) {
  const double signal = sites.errors.cwiseProduct(weights).sum();
  if (sites.place_share > 0.0)
    return std::max(0.0, signal / (2.0 * static_cast<double>(sites.size() - terms)));
  const double freedom = sites.counts.sum() - static_cast<double>(terms);
  const double scatter = ridge > 0.0 ? sites.scatter.sum() / ridge : 0.0;
  return std::max(0.0, (signal + scatter) / (2.0 * freedom));
}

/// The leave-one-out error over (log width, log ridge); it remembers the best point. Sites far
/// apart hardly tell a small ridge from none, so that a fit may mistake noise for error. Where the
/// fit finds less noise than the instruments state, the error is increased in proportion.
class LeaveOneOutCost {
 public:
  /// `span` is the kernel's.
  LeaveOneOutCost(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape,
                  double span)
      : sites_(sites),
        shape_(shape),
        span_(span),
        weights_(sites.weights()),
        squared_distances_(squared_distances(sites.positions)),
        tail_(tail_basis.at_each(sites.positions, sites.directions)) {}

  double operator()(double log_width, double log_ridge) {
    if (log_width != kernel_log_width_) {
      kernel_log_width_ = log_width;
      kernel_matrix(kernel_of(log_width), squared_distances_, kernel_);
    }
    const auto fit = fit_of(std::exp(log_ridge));
    const double loo_rms = fit ? sites_.sample_rms(fit->residuals) : kUnsolvable;
    const double cost = fit ? loo_rms * std::max(1.0, least_noise_ / fit->noise_sigma) : loo_rms;
    if (!(cost < kUnsolvable)) return kUnsolvable;
    if (cost < best_cost_) {
      best_cost_ = cost;
      best_loo_rms_ = loo_rms;
      best_ = {log_width, log_ridge};
      best_residuals_ = fit->residuals;
    }
    return cost;
  }

  /// Sets the least noise, as stated but no more than the error, and forgets the best point.
  void require_stated_noise(double loo_rms) {
    least_noise_ = std::min(sites_.stated_sigma, loo_rms * std::sqrt(0.5));
    best_cost_ = std::numeric_limits<double>::infinity();
  }

  double best_loo_rms() const { return best_loo_rms_; }

  TunedKernel best_kernel(double slope) const {
    const Eigen::ArrayXd misses2 = best_residuals_.colwise().squaredNorm();
    return {kernel_of(best_[0]), std::exp(best_[1]), slope, best_loo_rms_,
            misses2 * sites_.counts.array()};
  }

 private:
  RadialKernel kernel_of(double log_width) const { return {shape_, std::exp(log_width), span_}; }

  struct Fit {
    Eigen::Matrix2Xd residuals;  ///< of the sites when left out
    double noise_sigma{0.0};
  };

  /// Fits with the present kernel; empty where the equations cannot be solved.
  std::optional<Fit> fit_of(double ridge) {
    kernel_.diagonal() = 1.0 + ridge / weights_.array();
    const auto system = BorderedSystem::factorize(kernel_, tail_);
    if (!system) return {};
    const Eigen::Matrix2Xd weights = system->solve(sites_.errors.transpose()).weights.transpose();
    const double noise2 = ridge * signal_variance(sites_, weights, tail_.cols(), ridge);
    return Fit{leave_one_out(*system, weights).residuals, std::sqrt(noise2)};
  }

  static constexpr double kUnsolvable = std::numeric_limits<double>::max();

  const MapSites& sites_;
  KernelShape shape_;
  double span_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd squared_distances_, tail_;
  Eigen::MatrixXd kernel_;  ///< the diagonal belongs to the last ridge
  double kernel_log_width_{std::numeric_limits<double>::quiet_NaN()};
  std::vector<double> best_;
  Eigen::Matrix2Xd best_residuals_;
  double least_noise_{0.0};  ///< per axis, metres
  double best_loo_rms_{0.0};
  double best_cost_{std::numeric_limits<double>::infinity()};
};

struct SearchBox {
  double narrowest{0.0}, widest{0.0};  ///< log width

  double width_step() const { return (widest - narrowest) / (kGridWidths - 1); }
  double grid_log_width(std::size_t i) const {
    return std::min(widest, narrowest + static_cast<double>(i) * width_step());
  }
};

SearchBox search_box(const Eigen::Matrix2Xd& positions) {
  return {std::log(kNarrowestInSpacings * median_spacing(positions)), std::log(span_of(positions))};
}

/// Returns all sites, or at most `most` of them evenly drawn.
MapSites part_of(const MapSites& sites, Eigen::Index most) {
  return sites.every((sites.size() + most - 1) / most);
}

/// Returns where the parabola through three values at -1, 0 and 1 is least, within these.
double vertex(double before, double middle, double after) {
  const double curvature = before - 2.0 * middle + after;
  return curvature > 0.0 ? std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0) : 0.0;
}

/// Returns the logarithm of the ridge with the least error at one width. It goes downhill on the
/// grid's ridges from `nearest`, which it sets to the best of them. Of ridges that make no
/// difference (all small ones, where the sites lie far apart) it takes the largest.
double best_log_ridge(double log_width, std::size_t& nearest, LeaveOneOutCost& cost) {
  std::array<double, kGridRidges> costs;
  costs.fill(std::numeric_limits<double>::quiet_NaN());
  const auto cost_of = [&](std::size_t i) {
    if (std::isnan(costs[i])) costs[i] = cost(log_width, grid_log_ridge(i));
    return costs[i];
  };
  for (;;) {
    if (nearest + 1 < kGridRidges && kSame * cost_of(nearest + 1) <= cost_of(nearest))
      ++nearest;
    else if (nearest > 0 && cost_of(nearest - 1) < kSame * cost_of(nearest))
      --nearest;
    else
      break;
  }
  const double at = grid_log_ridge(nearest);
  if (nearest == 0 || nearest + 1 == kGridRidges) return at;
  return at + kRidgeStep * vertex(cost_of(nearest - 1), cost_of(nearest), cost_of(nearest + 1));
}

struct GridBest {
  double log_width{0.0}, log_ridge{0.0};
  double slope{0.0};  ///< of the best ridge there: d log ridge / d log width
};

/// Returns the grid's best point for the cost on a part of the sites.
GridBest search_grid(const SearchBox& box, LeaveOneOutCost& cost) {
  std::array<double, kGridWidths> log_ridges{};
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  std::size_t nearest = kGridRidges - 1;
  for (std::size_t i = 0; i < kGridWidths; ++i) {
    log_ridges[i] = best_log_ridge(box.grid_log_width(i), nearest, cost);
    const double here = cost(box.grid_log_width(i), log_ridges[i]);
    if (here < least) {
      least = here;
      best = i;
    }
  }
  const std::size_t before = best > 0 ? best - 1 : 0;
  const std::size_t after = std::min(best + 1, kGridWidths - 1);
  return {box.grid_log_width(best), log_ridges[best],
          (log_ridges[after] - log_ridges[before]) /
              (box.grid_log_width(after) - box.grid_log_width(before))};
}

/// The error over (log width, log ridge) along its valley, which runs obliquely to both.
struct Valley {
  LeaveOneOutCost& cost;
  std::vector<double> start;
  double slope;

  double operator()(double log_width, double above) const {
    const double log_ridge = start[1] + above + slope * (log_width - start[0]);
    return cost(log_width, std::clamp(log_ridge, kLogSmallestRidge, kLogLargestRidge));
  }
};

void search_along(Valley valley, const SearchBox& box) {
  nlopt::opt search(nlopt::LN_BOBYQA, 2);
  search.set_lower_bounds({box.narrowest, kLogSmallestRidge - kLogLargestRidge});
  search.set_upper_bounds({box.widest, kLogLargestRidge - kLogSmallestRidge});
  search.set_initial_step({0.5 * box.width_step(), 0.5 * kRidgeStep});
  search.set_xtol_abs(kLogTolerance);
  search.set_maxeval(kLocalEvaluations);
  search.set_min_objective(
      [](const std::vector<double>& x, std::vector<double>&, void* data) {
        return (*static_cast<const Valley*>(data))(x[0], x[1]);
      },
      &valley);
  std::vector<double> at{valley.start[0], 0.0};
  double reached = 0.0;
  try {
    search.optimize(at, reached);
  } catch (const nlopt::roundoff_limited&) {
    // The search went as far as rounding allows, and its result counts.
  }
}

bool is_clearly_better(const TunedKernel& other, const TunedKernel& first) {
  const Eigen::ArrayXd gains = first.squared_misses - other.squared_misses;
  return gains.sum() > standard_error_of_sum(gains);
}

TailBasis tail_of(const MapSites& sites, const RbfFamily& family) {
  if (!family.with_direction) return tail_for(sites.positions, family.tail_degree);
  return tail_for(sites.positions, family.tail_degree, sites.directions);
}

std::vector<TunedFamily> tune_each(const MapSites& sites, const std::vector<RbfFamily>& families) {
  std::vector<TunedFamily> tuned(families.size());
  parallel_for(
      families.size(), static_cast<unsigned>(families.size()), [] { return 0; },
      [&](std::size_t i, int) { tuned[i] = tune(sites, families[i]); });
  return tuned;
}

}  // namespace

TunedKernel tune_rbf(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape) {
  const MapSites part = part_of(sites, kLargestPart);
  const SearchBox box = search_box(part.positions);
  const double span = span_of(sites.positions);
  const MapSites rough = part_of(part, kRoughPart);
  LeaveOneOutCost rough_cost(rough, tail_like(tail_basis, rough.positions, rough.directions), shape,
                             span);
  const GridBest start = search_grid(box, rough_cost);
  LeaveOneOutCost cost(part, tail_basis, shape, span);
  cost(start.log_width, start.log_ridge);
  cost.require_stated_noise(cost.best_loo_rms());
  search_along({cost, {start.log_width, start.log_ridge}, start.slope}, box);
  return cost.best_kernel(start.slope);
}

double standard_error_of_sum(const Eigen::ArrayXd& draws) {
  const auto n = static_cast<double>(draws.size());
  return std::sqrt((draws - draws.mean()).square().sum() * n / (n - 1.0));
}

RbfFit fit_rbf(const MapSites& sites, const TailBasis& tail_basis, const RadialKernel& kernel,
               double ridge) {
  RbfParameters parameters;
  parameters.centers = sites.positions;
  parameters.counts = sites.weights();
  parameters.tail_basis = tail_basis;
  if (tail_basis.with_direction) parameters.directions = sites.directions;
  parameters.kernel = kernel;
  parameters.ridge = ridge;
  parameters.region = region_around(sites.positions);
  std::shared_ptr<const BorderedSystem> equations = map_equations(parameters);
  const BorderedSystem::Solution solution = equations->solve(sites.errors.transpose());
  parameters.weights = solution.weights.transpose();
  parameters.tail = solution.tail.transpose();
  LeaveOneOut left_out = leave_one_out(*equations, parameters.weights);
  const Eigen::ArrayXd site_noise2 = ridge / parameters.counts.array();
  const double loneliest2 = (left_out.unit_sigmas.array().square() - site_noise2).maxCoeff();
  parameters.signal_sigma =
      std::sqrt(signal_variance(sites, parameters.weights, tail_basis.terms(), ridge));
  parameters.sigma_limit = parameters.signal_sigma * std::sqrt(std::max(0.0, loneliest2));
  return {RbfMap(std::move(parameters), std::move(equations)), std::move(left_out)};
}

TunedFamily tune(const MapSites& sites, const RbfFamily& family) {
  const TailBasis tail_basis = tail_of(sites, family);
  return {family, tail_basis, tune_rbf(sites, tail_basis, family.shape)};
}

std::vector<TunedFamily> tune(const MapSites& sites, const std::vector<RbfFamily>& families) {
  std::vector<TunedFamily> tuned = tune_each(sites, families);
  std::vector<RbfFamily> directed = families;
  for (RbfFamily& family : directed) family.with_direction = true;
  if (!tail_of(sites, directed.front()).with_direction) return tuned;
  std::vector<TunedFamily> directed_tuned = tune_each(sites, directed);
  const bool better = is_clearly_better(directed_tuned.front().tuned, tuned.front().tuned);
  return better ? directed_tuned : tuned;
}

TunedFamily retune(const MapSites& sites, const TunedFamily& before) {
  const TailBasis tail_basis = tail_of(sites, before.family);
  const TunedKernel& tuned = before.tuned;
  const MapSites part = part_of(sites, kLargestPart);
  const SearchBox box = search_box(part.positions);
  LeaveOneOutCost cost(part, tail_basis, tuned.kernel.shape, span_of(sites.positions));
  const std::vector<double> start{
      std::clamp(std::log(tuned.kernel.width), box.narrowest, box.widest), std::log(tuned.ridge)};
  cost.require_stated_noise(tuned.loo_rms);
  search_along({cost, start, tuned.slope}, box);
  return {before.family, tail_basis, cost.best_kernel(tuned.slope)};
}

RbfFit fit_rbf(const MapSites& sites, const TunedFamily& family) {
  return fit_rbf(sites, family.tail_basis, family.tuned.kernel, family.tuned.ridge);
}

RbfFit fit_hand_width(const MapSites& sites, double width) {
  TailBasis no_tail;
  no_tail.degree = -1;
  return fit_rbf(sites, no_tail, {KernelShape::kGaussian, width, 0.0}, 0.0);
}

const TunedFamily& best_of(const std::vector<TunedFamily>& families) {
  const TunedFamily* best = &families.front();
  for (const TunedFamily& other : families)
    if (other.tuned.loo_rms < best->tuned.loo_rms &&
        is_clearly_better(other.tuned, families.front().tuned))
      best = &other;
  return *best;
}

}  // namespace planar
