#include "error_map/tuning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlopt.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "error_map/bordered_system.h"
#include "error_map/leave_one_out.h"
#include "error_map/valid_region.h"

namespace planar {
namespace {

constexpr Eigen::Index kLargestPart = 500;

// The search box. Narrower than half the samples' spacing a kernel reaches no neighbour; wider
// than their span it is a polynomial.
constexpr double kNarrowestInSpacings = 0.5;
constexpr double kWidestInSpans = 1.0;
constexpr double kSmallestRidge = 1e-10;
constexpr double kLargestRidge = 1e3;

constexpr int kGridWidths = 6;
constexpr std::array<double, 4> kGridRidges{1e-7, 1e-5, 1e-3, 1e-1};
constexpr int kLocalEvaluations = 30;
constexpr double kLogTolerance = 0.02;  // of width and ridge: the error is flat about its minimum

/// The leave-one-out error over (log width, log ridge), which remembers the best point it saw.
class LeaveOneOutCost {
 public:
  LeaveOneOutCost(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape)
      : sites_(sites),
        shape_(shape),
        span_(span_of(sites.positions)),
        squared_distances_(squared_distances(sites.positions)),
        tail_(tail_basis.at_each(sites.positions)) {}

  double operator()(double log_width, double log_ridge) {
    if (log_width != kernel_log_width_) {
      kernel_log_width_ = log_width;
      kernel_matrix(kernel_of(log_width), squared_distances_, kernel_);
    }
    const auto residuals = left_out_residuals(std::exp(log_ridge));
    const double cost = residuals ? sites_.sample_rms(*residuals) : kUnsolvable;
    if (!std::isfinite(cost)) return kUnsolvable;
    if (cost < best_cost_) {
      best_cost_ = cost;
      best_ = {log_width, log_ridge};
      best_residuals_ = *residuals;
    }
    return cost;
  }

  /// Log width, log ridge.
  const std::vector<double>& best() const { return best_; }

  TunedKernel best_kernel() const {
    const Eigen::ArrayXd misses2 = best_residuals_.colwise().squaredNorm();
    return {kernel_of(best_[0]), std::exp(best_[1]), best_cost_, misses2 * sites_.counts.array()};
  }

 private:
  RadialKernel kernel_of(double log_width) const { return {shape_, std::exp(log_width), span_}; }

  /// Of the present kernel; empty where it cannot be solved.
  std::optional<Eigen::Matrix2Xd> left_out_residuals(double ridge) const {
    Eigen::MatrixXd ridged = kernel_;
    ridged.diagonal().array() += ridge / sites_.counts.array();
    const auto system = BorderedSystem::factorize(std::move(ridged), tail_);
    if (!system) return {};
    const Eigen::Matrix2Xd weights = system->solve(sites_.errors.transpose()).weights.transpose();
    return leave_one_out(*system, weights).residuals;
  }

  static constexpr double kUnsolvable = std::numeric_limits<double>::max();

  const MapSites& sites_;
  KernelShape shape_;
  double span_;
  Eigen::MatrixXd squared_distances_;
  Eigen::MatrixXd tail_;
  Eigen::MatrixXd kernel_;
  double kernel_log_width_{std::numeric_limits<double>::quiet_NaN()};
  std::vector<double> best_;
  Eigen::Matrix2Xd best_residuals_;
  double best_cost_{std::numeric_limits<double>::infinity()};
};

struct SearchBox {
  double narrowest{0.0};  ///< log width
  double widest{0.0};

  double width_step() const { return (widest - narrowest) / (kGridWidths - 1); }
};

SearchBox search_box(const Eigen::Matrix2Xd& positions) {
  return {std::log(kNarrowestInSpacings * median_spacing(positions)),
          std::log(kWidestInSpans * span_of(positions))};
}

void search_grid(const SearchBox& box, LeaveOneOutCost& cost) {
  for (int i = 0; i < kGridWidths; ++i) {
    const double log_width = std::min(box.widest, box.narrowest + i * box.width_step());
    for (const double ridge : kGridRidges) cost(log_width, std::log(ridge));
  }
}

void search_near(std::vector<double> at, const SearchBox& box, LeaveOneOutCost& cost) {
  nlopt::opt search(nlopt::LN_BOBYQA, 2);
  search.set_lower_bounds({box.narrowest, std::log(kSmallestRidge)});
  search.set_upper_bounds({box.widest, std::log(kLargestRidge)});
  search.set_initial_step(
      {0.5 * box.width_step(), 0.5 * std::log(kGridRidges[1] / kGridRidges[0])});
  search.set_xtol_abs(kLogTolerance);
  search.set_maxeval(kLocalEvaluations);
  search.set_min_objective(
      [](const std::vector<double>& x, std::vector<double>&, void* data) {
        return (*static_cast<LeaveOneOutCost*>(data))(x[0], x[1]);
      },
      &cost);
  double reached = 0.0;
  try {
    search.optimize(at, reached);
  } catch (const nlopt::roundoff_limited&) {
    // As good as rounding allows: a result like any other.
  }
}

/// Every site, or about kLargestPart of them evenly drawn.
MapSites part_of(const MapSites& sites) {
  const Eigen::Index stride = (sites.size() + kLargestPart - 1) / kLargestPart;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < sites.size(); i += stride) kept.push_back(i);
  return sites.subset(kept);
}

}  // namespace

TunedKernel tune_rbf(const MapSites& sites, const TailBasis& tail_basis, KernelShape shape) {
  const MapSites part = part_of(sites);
  const SearchBox box = search_box(part.positions);
  LeaveOneOutCost cost(part, tail_basis, shape);
  search_grid(box, cost);
  search_near(cost.best(), box, cost);
  return cost.best_kernel();
}

TunedKernel retune_rbf(const MapSites& sites, const TailBasis& tail_basis,
                       const TunedKernel& before) {
  const MapSites part = part_of(sites);
  const SearchBox box = search_box(part.positions);
  LeaveOneOutCost cost(part, tail_basis, before.kernel.shape);
  search_near(
      {std::clamp(std::log(before.kernel.width), box.narrowest, box.widest),
       std::clamp(std::log(before.ridge), std::log(kSmallestRidge), std::log(kLargestRidge))},
      box, cost);
  return cost.best_kernel();
}

}  // namespace planar
