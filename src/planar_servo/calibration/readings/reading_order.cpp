#include "planar_servo/calibration/readings/reading_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kViewTerms = 12;
constexpr Eigen::Index kLeastPlaces = 2 * kViewTerms;
constexpr double kUnrelatedShare = 0.25;
constexpr double kRelatedShare = 0.02;
constexpr int kMostRows = 3;
constexpr double kMovedLampsPx = 1.0;

/// Returns the terms of a smooth view: a cubic of the lamps' middle, and the tool's direction.
Eigen::Matrix<double, 1, kViewTerms> view_terms(const ToolSight& sight,
                                                const Eigen::Vector2d& centre_px, double size_px) {
  const Eigen::Vector2d axis = (sight.lamps_px[1] - sight.lamps_px[0]).normalized();
  const Eigen::Vector2d m = (0.5 * (sight.lamps_px[0] + sight.lamps_px[1]) - centre_px) / size_px;
  const double u = m.x(), v = m.y();
  Eigen::Matrix<double, 1, kViewTerms> terms;
  terms << 1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v, axis.x(),
      axis.y();
  return terms;
}

Eigen::MatrixXd view_matrix(const std::vector<ToolSight>& sights) {
  Eigen::Matrix2Xd middles(2, sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i)
    middles.col(static_cast<Eigen::Index>(i)) =
        0.5 * (sights[i].lamps_px[0] + sights[i].lamps_px[1]);
  const Eigen::Vector2d centre = middles.rowwise().mean();
  const double size = std::sqrt((middles.colwise() - centre).colwise().squaredNorm().mean());
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(sights.size()), kViewTerms);
  for (std::size_t i = 0; i < sights.size(); ++i)
    terms.row(static_cast<Eigen::Index>(i)) = view_terms(sights[i], centre, size);
  return terms;
}

/// Returns the share of the readings' spread that a smooth view leaves in the median.
double share_left(const Eigen::MatrixXd& terms, const Eigen::MatrixX2d& readings) {
  Eigen::MatrixX2d left = readings;
  for (int axis = 0; axis < 2; ++axis)
    left.col(axis) -= terms * solve_least_squares(terms, readings.col(axis));
  const Eigen::MatrixX2d centred = readings.rowwise() - readings.colwise().mean();
  const double spread = std::sqrt(centred.rowwise().squaredNorm().mean());
  const Eigen::VectorXd lengths = left.rowwise().norm();
  return median({lengths.begin(), lengths.end()}) / spread;
}

Eigen::MatrixX2d reflectors(const std::vector<ToolSight>& sights) {
  Eigen::MatrixX2d points(static_cast<Eigen::Index>(sights.size()), 2);
  for (std::size_t i = 0; i < sights.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) = sights[i].p_reflector_B.head<2>().transpose();
  return points;
}

double share_left(const std::vector<ToolSight>& sights) {
  return share_left(view_matrix(sights), reflectors(sights));
}

/// Returns by how many rows the readings come late, if the lamps follow them then.
std::optional<int> late_rows(const std::vector<ToolSight>& sights) {
  const Eigen::MatrixXd terms = view_matrix(sights);
  const Eigen::MatrixX2d points = reflectors(sights);
  for (int rows = 1; rows <= kMostRows; ++rows) {
    const Eigen::Index n = points.rows() - rows;
    if (n < kLeastPlaces) break;
    if (share_left(terms.topRows(n), points.bottomRows(n)) < kRelatedShare) return rows;
    if (share_left(terms.bottomRows(n), points.topRows(n)) < kRelatedShare) return -rows;
  }
  return std::nullopt;
}

void require_rows_in_order(const std::vector<ToolSight>& sights) {
  const auto rows = late_rows(sights);
  if (!rows) return;
  throw InputError(fmt::format(
      "tracker: its readings are shifted by {} row{} against their ids: with the place {} its own "
      "each follows the lamps; put the rows of the tracker's table back",
      std::abs(*rows), std::abs(*rows) == 1 ? "" : "s", *rows > 0 ? "before" : "after"));
}

}  // namespace

void require_reading_order(const std::vector<ToolSight>& sights, PairBy by) {
  const bool enough = static_cast<Eigen::Index>(sights.size()) > kLeastPlaces;
  const double share = enough ? share_left(sights) : 1.0;
  const bool follow = share < kRelatedShare;
  if (follow || !enough) return;
  if (by == PairBy::kId) require_rows_in_order(sights);
  if (share < kUnrelatedShare) return;
  throw InputError(fmt::format(
      "tracker: its readings do not follow the lamps: the best smooth view of {} places misses "
      "them by {:.0f} % of the field; check that ids, times and order belong to this recording",
      sights.size(), 100.0 * share));
}

std::vector<Rejection> take_out_frozen(std::vector<ToolSight>& sights) {
  std::vector<Rejection> frozen;
  std::vector<ToolSight> alive;
  for (ToolSight& sight : sights) {
    const bool repeated = !alive.empty() && sight.p_reflector_B == alive.back().p_reflector_B &&
                          (sight.lamps_px[0] - alive.back().lamps_px[0]).norm() > kMovedLampsPx;
    if (repeated)
      frozen.push_back({sight.id, "frozen: the tracker's reading is that of '" + alive.back().id +
                                      "' to the last digit, while the lamps moved"});
    else
      alive.push_back(std::move(sight));
  }
  sights = std::move(alive);
  return frozen;
}

}  // namespace planar
