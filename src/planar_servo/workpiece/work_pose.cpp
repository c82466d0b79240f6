#include "planar_servo/workpiece/work_pose.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"

namespace planar {
namespace {

using Terms = Eigen::Matrix<double, 6, 1>;  // t, then the columns of A
using PointRows = Eigen::Matrix<double, 2, 6>;

/// Returns d p_B / d (t, columns of A).
PointRows rows_at(const Eigen::Vector2d& p_W) {
  PointRows rows;
  rows << Eigen::Matrix2d::Identity(), p_W.x() * Eigen::Matrix2d::Identity(),
      p_W.y() * Eigen::Matrix2d::Identity();
  return rows;
}

/// Returns d (t, columns of A) / d unknowns, which turn, stretch and shift the drawing about
/// `middle` (drawing's frame) to first order.
Eigen::MatrixXd directions_of(WorkMap map, const WorkPose& pose, const Eigen::Vector2d& middle) {
  const auto change = [&](const Eigen::Matrix2d& step) {
    Terms terms;
    terms << -step * middle, step.col(0), step.col(1);
    return terms;
  };
  Eigen::Matrix2d turn, flat, shear;
  turn << 0.0, -1.0, 1.0, 0.0;
  flat << 1.0, 0.0, 0.0, -1.0;
  shear << 0.0, 1.0, 1.0, 0.0;
  const Eigen::Index unknowns =
      static_cast<Eigen::Index>(2 * least_marks(map)) - (map == WorkMap::kRigid ? 1 : 0);
  Eigen::MatrixXd all(6, 6);
  all.leftCols<2>() = Eigen::Matrix<double, 6, 2>::Identity();
  all.col(2) = change(turn * pose.A);
  all.col(3) = change(pose.A);
  all.col(4) = change(pose.A * flat);
  all.col(5) = change(pose.A * shear);
  return all.leftCols(unknowns);
}

WorkPose start_of(const WorkMarks& marks) {
  const Eigen::Isometry2d X_BW = fit_rigid_2d(marks.p_B, marks.p_W);
  WorkPose pose;
  pose.A = X_BW.linear();
  pose.t = X_BW.translation();
  return pose;
}

/// Returns the pose moved by a step of its terms; a rigid one keeps its lengths.
WorkPose moved(WorkPose pose, const Terms& step, const Eigen::Vector2d& middle) {
  const Eigen::Vector2d seen = pose.in_base(middle) + rows_at(middle) * step;
  pose.A.col(0) += step.segment<2>(2);
  pose.A.col(1) += step.segment<2>(4);
  if (pose.map == WorkMap::kRigid) pose.A = rotation2d(pose.turn());
  pose.t = seen - pose.A * middle;
  return pose;
}

Eigen::VectorXd stacked(const Eigen::Matrix2Xd& columns) {
  return Eigen::Map<const Eigen::VectorXd>(columns.data(), columns.size());
}

}  // namespace

Eigen::Matrix2d WorkPose::covariance_at(const Eigen::Vector2d& p_W) const {
  const PointRows rows = rows_at(p_W);
  return rows * covariance * rows.transpose();
}

double WorkPose::turn() const {
  return std::atan2(A(1, 0) - A(0, 1), A(0, 0) + A(1, 1));
}

double WorkPose::scale() const {
  return std::sqrt(std::abs(A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0)));
}

WorkMarks WorkMarks::without(std::size_t left_out) const {
  std::vector<Eigen::Index> marks, rows;
  WorkMarks rest;
  for (std::size_t i = 0; i < size(); ++i) {
    if (i == left_out) continue;
    const auto mark = static_cast<Eigen::Index>(i);
    rest.ids.push_back(ids[i]);
    marks.push_back(mark);
    rows.insert(rows.end(), {2 * mark, 2 * mark + 1});
  }
  rest.p_W = p_W(Eigen::all, marks);
  rest.p_B = p_B(Eigen::all, marks);
  rest.own = own(rows, rows);
  rest.shared = shared(rows, rows);
  return rest;
}

double WorkFit::chance() const {
  return freedom > 0 ? chi_square_tail(chi2, freedom) : 1.0;
}

std::size_t least_marks(WorkMap map) {
  return map == WorkMap::kAffine ? 3 : 2;
}

std::optional<WorkFit> fit_work(const WorkMarks& marks, WorkMap map) {
  if (marks.size() < least_marks(map)) return std::nullopt;
  const auto L = lower_factor(marks.covariance());
  if (!L) return std::nullopt;
  const Eigen::Vector2d middle = marks.p_W.rowwise().mean();
  Eigen::MatrixXd rows(2 * marks.size(), 6);
  for (std::size_t i = 0; i < marks.size(); ++i)
    rows.middleRows<2>(static_cast<Eigen::Index>(2 * i)) =
        rows_at(marks.p_W.col(static_cast<Eigen::Index>(i)));
  WorkFit fit;
  fit.pose = start_of(marks);
  fit.pose.map = map;
  constexpr int kSteps = 8;  // a rigid turn converges in three; the others are linear
  for (int step = 0; step <= kSteps; ++step) {
    const Eigen::Matrix2Xd misses = marks.p_B - ((fit.pose.A * marks.p_W).colwise() + fit.pose.t);
    const Eigen::VectorXd white = solve_lower(*L, stacked(misses));
    const Eigen::MatrixXd directions = directions_of(map, fit.pose, middle);
    const Eigen::MatrixXd J = solve_lower(*L, rows * directions);
    const auto inverse =
        solve_positive(J.transpose() * J, Eigen::MatrixXd::Identity(J.cols(), J.cols()), 1e-14);
    if (!inverse) return std::nullopt;
    fit.pose.covariance = directions * *inverse * directions.transpose();
    const Eigen::VectorXd own = marks.own * solve_lower_transposed(*L, white);
    fit.residuals = Eigen::Map<const Eigen::Matrix2Xd>(own.data(), 2, misses.cols());
    fit.chi2 = white.squaredNorm();
    fit.freedom = static_cast<int>(J.rows() - J.cols());
    if (step < kSteps)
      fit.pose = moved(fit.pose, directions * (*inverse * (J.transpose() * white)), middle);
  }
  return fit;
}

std::optional<ContradictingMark> contradicting_mark(const WorkMarks& marks, WorkMap map) {
  std::optional<ContradictingMark> odd;
  const auto all = fit_work(marks, map);
  if (!all) return std::nullopt;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const auto rest = fit_work(marks.without(i), map);
    if (!rest || rest->freedom == 0 || rest->chance() < kFalseAlarm) continue;
    // A mark adds its two numbers' chi squared, whatever it shares with the others.
    if (chi_square_tail(std::max(0.0, all->chi2 - rest->chi2), 2) >= kFalseAlarm) continue;
    if (odd) return std::nullopt;
    const auto mark = static_cast<Eigen::Index>(i);
    odd = {i, (marks.p_B.col(mark) - rest->pose.in_base(marks.p_W.col(mark))).norm()};
  }
  return odd;
}

}  // namespace planar
