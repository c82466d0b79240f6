#include "error_map/tuning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlopt.hpp>
#include <utility>
#include <vector>

#include "error_map/bordered_system.h"
#include "error_map/kernel_matrix.h"
#include "error_map/leave_one_out.h"
#include "error_map/valid_region.h"

namespace planar {
namespace {

constexpr Eigen::Index kLargestPart = 1000;

// The search box. Narrower than half the samples' spacing a Gaussian reaches no neighbour; wider
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
  LeaveOneOutCost(const MapSites& sites, const TailBasis& tail_basis)
      : sites_(sites),
        squared_distances_(squared_distances(sites.positions)),
        tail_(tail_basis.at_each(sites.positions)) {}

  double operator()(double log_width, double log_ridge) {
    if (log_width != kernel_log_width_) {
      kernel_log_width_ = log_width;
      gaussian_kernel(squared_distances_, std::exp(log_width), kernel_);
    }
    const double cost = loo_rms(std::exp(log_ridge));
    if (cost < best_cost_) {
      best_cost_ = cost;
      best_ = {log_width, log_ridge};
    }
    return cost;
  }

  /// Log width, log ridge.
  const std::vector<double>& best() const { return best_; }

  TunedKernel best_kernel() const { return {std::exp(best_[0]), std::exp(best_[1]), best_cost_}; }

 private:
  /// Of the present kernel; huge where it cannot be solved.
  double loo_rms(double ridge) const {
    Eigen::MatrixXd ridged = kernel_;
    ridged.diagonal().array() += ridge / sites_.counts.array();
    const auto system = BorderedSystem::factorize(std::move(ridged), tail_);
    if (!system) return std::numeric_limits<double>::max();
    const Eigen::Matrix2Xd weights = system->solve(sites_.errors.transpose()).weights.transpose();
    const double rms = sites_.sample_rms(leave_one_out(*system, weights).residuals);
    return std::isfinite(rms) ? rms : std::numeric_limits<double>::max();
  }

  const MapSites& sites_;
  Eigen::MatrixXd squared_distances_;
  Eigen::MatrixXd tail_;
  Eigen::MatrixXd kernel_;
  double kernel_log_width_{std::numeric_limits<double>::quiet_NaN()};
  std::vector<double> best_;
  double best_cost_{std::numeric_limits<double>::infinity()};
};

struct SearchBox {
  double narrowest{0.0};  ///< log width
  double widest{0.0};

  double width_step() const { return (widest - narrowest) / (kGridWidths - 1); }
};

SearchBox search_box(const Eigen::Matrix2Xd& positions) {
  const Eigen::Vector2d span = positions.rowwise().maxCoeff() - positions.rowwise().minCoeff();
  return {std::log(kNarrowestInSpacings * median_spacing(positions)),
          std::log(kWidestInSpans * span.norm())};
}

void search_grid(const SearchBox& box, LeaveOneOutCost& cost) {
  for (int i = 0; i < kGridWidths; ++i) {
    const double log_width = std::min(box.widest, box.narrowest + i * box.width_step());
    for (const double ridge : kGridRidges) cost(log_width, std::log(ridge));
  }
}

void search_near_best(const SearchBox& box, LeaveOneOutCost& cost) {
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
  std::vector<double> at = cost.best();
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

TunedKernel tune_gaussian(const MapSites& sites, const TailBasis& tail_basis) {
  const MapSites part = part_of(sites);
  const SearchBox box = search_box(part.positions);
  LeaveOneOutCost cost(part, tail_basis);
  search_grid(box, cost);
  search_near_best(box, cost);
  return cost.best_kernel();
}

}  // namespace planar
