#include "marker/ellipse_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/statistics.h"
#include "core/units.h"
#include "marker/edge_noise.h"
#include "marker/kasa_circle.h"

namespace planar {
namespace {

constexpr int kRounds = 3;
constexpr int kMostSteps = 20;
constexpr double kRejectAt = 3.0;        // robust standard deviations
constexpr double kLeastSigma_px = 1e-9;  // keeps exact points from rejecting one another
constexpr std::size_t kLeastEdges = 8;

// Parameters of an ellipse: center x, y; shape 11, 22, 12.
using Parameters = Eigen::Matrix<double, 5, 1>;

/// Columns: the combinations of parameters that a fit may change.
Eigen::MatrixXd freedom(bool circle) {
  if (!circle) return Eigen::MatrixXd::Identity(5, 5);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(5, 3);
  basis(0, 0) = basis(1, 1) = basis(2, 2) = basis(3, 2) = 1.0;
  return basis;
}

/// Signed distance of a point from the ellipse to first order, positive outside, and its gradient
/// by the parameters.
double distance(const Parameters& x, const Eigen::Vector2d& p, Parameters* gradient = nullptr) {
  Eigen::Matrix2d shape;
  shape << x[2], x[4], x[4], x[3];
  const Eigen::Vector2d d = p - x.head<2>();
  const Eigen::Vector2d q = shape * d;
  const double length = q.norm();
  const Eigen::Vector2d slope = shape * q / length;  // of |q| by p
  if (gradient != nullptr) {
    *gradient << -slope, q[0] * d[0] / length, q[1] * d[1] / length,
        (q[0] * d[1] + q[1] * d[0]) / length;
    *gradient /= slope.norm();
  }
  return (length - 1.0) / slope.norm();
}

struct Problem {
  const std::vector<Eigen::Vector2d>& edges;
  int reach;
  std::vector<bool> used;
};

struct Solution {
  Parameters x;
  std::vector<bool> used;
  double independent;  ///< edges
  Eigen::Matrix2d center_covariance;
  double sigma;
};

/// Normal equations J^T J and J^T r over the used edges; the sum of squares.
double assemble(const Problem& problem, const Parameters& x, Eigen::Matrix<double, 5, 5>& normal,
                Parameters& gradient) {
  normal.setZero();
  gradient.setZero();
  double sum = 0.0;
  Parameters row;
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    if (!problem.used[i]) continue;
    const double r = distance(x, problem.edges[i], &row);
    normal += row * row.transpose();
    gradient += row * r;
    sum += r * r;
  }
  return sum;
}

/// The solution with its uncertainty; empty when there are no edges to spare.
std::optional<Solution> state(const Problem& problem, const Parameters& x,
                              const Eigen::MatrixXd& basis) {
  std::vector<EdgeResidual> residuals;
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    if (!problem.used[i]) continue;
    const Eigen::Vector2d d = problem.edges[i] - x.head<2>();
    residuals.push_back({std::atan2(d.y(), d.x()), distance(x, problem.edges[i])});
  }
  const double n = static_cast<double>(residuals.size());
  const double shared = edges_per_independent(residuals, problem.reach);
  const double free_edges = n / shared - static_cast<double>(basis.cols());
  if (free_edges < 1.0) return std::nullopt;

  Eigen::Matrix<double, 5, 5> normal;
  Parameters gradient;
  const double sum = assemble(problem, x, normal, gradient);
  const double variance = sum / shared / free_edges;
  const Eigen::MatrixXd reduced = basis.transpose() * normal * basis;
  const Eigen::MatrixXd inverse =
      reduced.ldlt().solve(Eigen::MatrixXd::Identity(reduced.rows(), reduced.cols()));
  return Solution{x, problem.used, n / shared, variance * shared * inverse.topLeftCorner<2, 2>(),
                  std::sqrt(variance)};
}

std::optional<Solution> gauss_newton(const Problem& problem, Parameters x, bool circle) {
  constexpr double kSmallStep_px = 1e-7;
  const Eigen::MatrixXd basis = freedom(circle);
  Eigen::Matrix<double, 5, 5> normal;
  Parameters gradient;
  bool converged = false;
  for (int i = 0; i < kMostSteps && !converged; ++i) {
    assemble(problem, x, normal, gradient);
    const Eigen::LDLT<Eigen::MatrixXd> solver(basis.transpose() * normal * basis);
    const Parameters step = -basis * solver.solve(basis.transpose() * gradient);
    if (!step.allFinite() || !solver.isPositive()) return std::nullopt;
    x += step;
    converged = step.head<2>().norm() < kSmallStep_px;
  }
  if (!converged || !(x[2] * x[3] > x[4] * x[4])) return std::nullopt;

  return state(problem, x, basis);
}

/// Edges within a few robust standard deviations of the ellipse.
std::vector<bool> inliers(const std::vector<Eigen::Vector2d>& edges, const Parameters& x) {
  std::vector<double> distances;
  distances.reserve(edges.size());
  for (const Eigen::Vector2d& p : edges) distances.push_back(distance(x, p));
  const double bound = kRejectAt * std::max(robust_sigma(distances), kLeastSigma_px);
  const double centre = median(distances);
  std::vector<bool> used(edges.size());
  std::transform(distances.begin(), distances.end(), used.begin(),
                 [&](double r) { return std::abs(r - centre) <= bound; });
  return used;
}

std::optional<Solution> robust_fit(Problem problem, const Parameters& start, bool circle) {
  std::optional<Solution> solution = gauss_newton(problem, start, circle);
  for (int round = 0; round < kRounds && solution; ++round) {
    problem.used = inliers(problem.edges, solution->x);
    if (problem.used == solution->used) break;
    solution = gauss_newton(problem, solution->x, circle);
  }
  return solution;
}

/// The ellipse of the edges' own second moments: exact for a whole rim evenly covered.
std::optional<Parameters> moment_ellipse(const std::vector<Eigen::Vector2d>& edges) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : edges) mean += p / static_cast<double>(edges.size());
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : edges) {
    moments += 2.0 * (p - mean) * (p - mean).transpose() / static_cast<double>(edges.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments);
  if (!(axes.eigenvalues()[0] > 1e-9 * axes.eigenvalues()[1])) return std::nullopt;
  const Eigen::Matrix2d shape = axes.operatorInverseSqrt();
  Parameters x;
  x << mean, shape(0, 0), shape(1, 1), shape(0, 1);
  return x;
}

bool ellipse_is_justified(const Solution& circle, const Solution& ellipse) {
  const double n = ellipse.independent;
  return 2.0 * n * std::log(circle.sigma / ellipse.sigma) > 2.0 * std::log(n);
}

double largest_gap(const Solution& solution, const std::vector<Eigen::Vector2d>& edges) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Eigen::Vector2d d = edges[i] - solution.x.head<2>();
    if (solution.used[i]) angles.push_back(std::atan2(d.y(), d.x()));
  }
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * kPi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap;
}

}  // namespace

double RimFit::diameter() const {
  return 2.0 / std::sqrt(shape.determinant());
}

std::optional<RimFit> fit_rim(const std::vector<Eigen::Vector2d>& edges, int reach) {
  if (edges.size() < kLeastEdges) return std::nullopt;
  const Problem problem{edges, reach, std::vector<bool>(edges.size(), true)};
  const std::optional<Circle> start = kasa_circle(edges);
  const std::optional<Parameters> moments = moment_ellipse(edges);
  if (!start || !moments) return std::nullopt;

  Parameters x;
  x << start->center, 1.0 / start->radius, 1.0 / start->radius, 0.0;
  const std::optional<Solution> circle = robust_fit(problem, x, true);
  const std::optional<Solution> ellipse = robust_fit(problem, *moments, false);
  if (!circle && !ellipse) return std::nullopt;
  const bool is_circle = !ellipse || (circle && !ellipse_is_justified(*circle, *ellipse));
  const Solution& best = is_circle ? *circle : *ellipse;

  RimFit fit;
  fit.center = best.x.head<2>();
  fit.shape << best.x[2], best.x[4], best.x[4], best.x[3];
  fit.is_circle = is_circle;
  fit.center_covariance = best.center_covariance;
  fit.sigma = best.sigma;
  fit.largest_gap = largest_gap(best, edges);
  fit.used = static_cast<int>(std::count(best.used.begin(), best.used.end(), true));
  return fit;
}

}  // namespace planar
