#include "planar_servo/learn/field/lay_information.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Deviation of a known pitch as a share: dots 1.5 m below a camera, at a height to 0.03 mm.
constexpr double kKnownPitch = 2e-5;
/// The same for one that is not, after it was measured through the camera.
constexpr double kUnknownPitch = 0.05;
/// Deviation of a printed pattern's aspect and right angles.
constexpr double kPrinted = 1e-3;
/// Fewer dots than this tell nothing but the place and turn of their lay.
constexpr Eigen::Index kFewestDots = 4;

Eigen::Matrix2Xd centred(const Eigen::Matrix2Xd& points) {
  return points.colwise() - points.rowwise().mean();
}

/// Returns the factor by which lays are seen larger than their board is.
double seen_scale(const std::vector<BoardLay>& lays) {
  double seen = 0.0, board = 0.0;
  for (const BoardLay& lay : lays) {
    seen += centred(lay.seen_B).squaredNorm();
    board += centred(lay.p_board).squaredNorm();
  }
  return std::sqrt(seen / board);
}

std::vector<BoardLay> on_disc(const std::vector<BoardLay>& lays, double radius) {
  std::vector<BoardLay> inner;
  for (const BoardLay& lay : lays) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < lay.seen_B.cols(); ++i)
      if (lay.seen_B.col(i).norm() <= radius) kept.push_back(i);
    if (static_cast<Eigen::Index>(kept.size()) >= kFewestDots)
      inner.push_back(
          {lay.id, lay.p_board(Eigen::all, kept), lay.seen_B(Eigen::all, kept), lay.sigma(kept)});
  }
  return inner;
}

/// The dots of one lay, as equations field . d_field + shape . d_shape + pose . d_pose = z, in rows
/// for x and for y that have unit variance. Columns of x and y: the shape's scale, aspect and
/// shear; the pose's shift x, shift y and turn; z.
struct LayRows {
  Eigen::MatrixXd field;  ///< of x, and the same of y
  Eigen::MatrixXd x, y;
};
constexpr Eigen::Index kShape = 3, kPose = 3, kColumns = kShape + kPose + 1;

LayRows rows_of(const BoardLay& lay, double scale, const FieldBasis& basis, double factor) {
  const Eigen::Index n = lay.seen_B.cols();
  const Eigen::Matrix2Xd p_board = scale * centred(lay.p_board);
  const Eigen::Isometry2d pose = fit_rigid_2d(lay.seen_B, p_board);
  const Eigen::Matrix2Xd place = pose * p_board, arm = pose.linear() * p_board;
  Eigen::Matrix2Xd mirrored = p_board, swapped = p_board.colwise().reverse();
  mirrored.row(1) *= -1.0;
  mirrored = pose.linear() * mirrored;
  swapped = pose.linear() * swapped;
  LayRows rows{Eigen::MatrixXd(n, basis.terms()), Eigen::MatrixXd(n, kColumns),
               Eigen::MatrixXd(n, kColumns)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d z = lay.seen_B.col(i) - place.col(i);
    rows.field.row(i) = basis.at(lay.seen_B.col(i));
    rows.x.row(i) << arm(0, i), mirrored(0, i), swapped(0, i), 1.0, 0.0, -arm(1, i), z.x();
    rows.y.row(i) << arm(1, i), mirrored(1, i), swapped(1, i), 0.0, 1.0, arm(0, i), z.y();
    for (Eigen::MatrixXd* part : {&rows.field, &rows.x, &rows.y})
      part->row(i) /= factor * lay.sigma[i];
  }
  return rows;
}

/// Returns what tells nothing of so many unknowns: the field's weights and others.
LayInformation nothing_of(Eigen::Index unknowns) {
  return {Eigen::MatrixXd::Zero(unknowns, unknowns), Eigen::VectorXd::Zero(unknowns)};
}

void add(const LayInformation& more, LayInformation& sums) {
  sums.H += more.H;
  sums.right += more.right;
  sums.squares += more.squares;
  sums.log_determinant += more.log_determinant;
}

/// Lets the last unknowns go, which stay free or have their prior in H.
LayInformation without_last(const LayInformation& sums, Eigen::Index count) {
  const Eigen::Index n = sums.right.size() - count;
  const Eigen::MatrixXd with_last = sums.H.topRightCorner(n, count);
  Eigen::MatrixXd right(count, n + 1);
  right << with_last.transpose(), sums.right.tail(count);
  const Eigen::MatrixXd solved = solve_symmetric(sums.H.bottomRightCorner(count, count), right);
  return {sums.H.topLeftCorner(n, n) - with_last * solved.leftCols(n),
          sums.right.head(n) - with_last * solved.col(n),
          sums.squares - sums.right.tail(count).dot(solved.col(n))};
}

/// Adds a lay, of which the pose is free: it takes its part of the squares away.
void add(const LayRows& rows, LayInformation& sums) {
  const Eigen::Index nb = rows.field.cols(), n = 2 * nb + kShape, all = n + kPose;
  LayInformation lay = nothing_of(all);
  Eigen::MatrixXd of_others(all + 1, kColumns);
  of_others << rows.field.transpose() * rows.x, rows.field.transpose() * rows.y,
      rows.x.transpose() * rows.x + rows.y.transpose() * rows.y;
  const Eigen::MatrixXd of_component = rows.field.transpose() * rows.field;
  lay.H.topLeftCorner(nb, nb) = of_component;
  lay.H.block(nb, nb, nb, nb) = of_component;
  lay.H.rightCols(kShape + kPose) = of_others.topLeftCorner(all, kShape + kPose);
  lay.H.bottomLeftCorner(kShape + kPose, 2 * nb) =
      of_others.topLeftCorner(2 * nb, kShape + kPose).transpose();
  lay.right = of_others.col(kColumns - 1).head(all);
  lay.squares = of_others(all, kColumns - 1);
  add(without_last(lay, kPose), sums);
}

LayInformation told_by_board(const LaidDots& board, const FieldBasis& basis, double factor) {
  const std::vector<BoardLay> lays = on_disc(board.lays, basis.radius);
  const Eigen::Index n = 2 * basis.terms();
  if (lays.empty()) return nothing_of(n);
  const double scale = board.pitch_known ? 1.0 : seen_scale(lays);
  LayInformation sums = nothing_of(n + kShape);
  double numbers = 0.0;
  for (const BoardLay& lay : lays) {
    add(rows_of(lay, scale, basis, factor), sums);
    numbers += 2.0 * static_cast<double>(lay.seen_B.cols()) - 3.0;
  }
  const Eigen::Vector3d prior(board.pitch_known ? kKnownPitch : kUnknownPitch, kPrinted, kPrinted);
  sums.H.diagonal().tail<3>() += prior.cwiseAbs2().cwiseInverse();
  const Eigen::Matrix3d of_shape = sums.H.bottomRightCorner<3, 3>();
  LayInformation field = without_last(sums, kShape);
  field.log_determinant = 2.0 * numbers * std::log(factor) + std::log(of_shape.determinant()) +
                          2.0 * prior.array().log().sum();
  return field;
}

/// What the bar and the marks tell. Seen length = length + its deviation + what the field adds from
/// end to end; seen place = place + field. The field is that of the lamps, so that both leave out
/// by how much lamps are shifted beside them: alike everywhere, and growing from the camera's foot.
LayInformation told_by_standards(const LaidDots& laid, const FieldBasis& basis) {
  // The last unknowns are the bar's deviation, the shift along x and y, and its growth.
  constexpr Eigen::Index kMore = 4, kShift = 1, kGrowth = 3;
  constexpr double kNone_m = 1e-9;
  const Eigen::Index terms = basis.terms(), n = 2 * terms;
  const double shift = std::max(laid.lamps_shift_sigma, kNone_m) / std::sqrt(2.0);
  const Eigen::Vector4d prior(std::max(laid.length_sigma, kNone_m), shift, shift,
                              shift / basis.radius);
  LayInformation sums = nothing_of(n + kMore);
  sums.H.diagonal().tail<kMore>() = prior.cwiseAbs2().cwiseInverse();
  Eigen::RowVectorXd row(n + kMore);
  const auto add_row = [&](double z, double sigma) {
    sums.H += (row / sigma).transpose() * (row / sigma);
    sums.right += row.transpose() * (z / (sigma * sigma));
    sums.squares += z * z / (sigma * sigma);
  };
  for (const LengthSight& sight : laid.lengths) {
    const auto& [first, second] = sight.seen_B;
    if (std::max(first.norm(), second.norm()) > basis.radius) continue;
    const double length = (second - first).norm();
    const Eigen::Vector2d along = (second - first) / length;
    const Eigen::RowVectorXd growth = basis.at(second) - basis.at(first);
    row << along.x() * growth, along.y() * growth, 1.0, 0.0, 0.0, length;
    add_row(length - laid.length, sight.sigma);
  }
  for (const MarkSight& mark : laid.marks) {
    if (mark.seen_B.norm() > basis.radius) continue;
    for (const Eigen::Index axis : {0, 1}) {
      row.setZero();
      row.segment(axis * terms, terms) = basis.at(mark.seen_B);
      row[n + kShift + axis] = 1.0;
      row[n + kGrowth] = (mark.seen_B - laid.foot_B)[axis];
      add_row((mark.seen_B - mark.p_B)[axis], mark.sigma);
    }
  }
  const Eigen::Matrix4d of_more = sums.H.bottomRightCorner<kMore, kMore>();
  LayInformation field = without_last(sums, kMore);
  field.log_determinant =
      std::log((prior.asDiagonal() * of_more * prior.asDiagonal()).determinant());
  return field;
}

}  // namespace

std::size_t LaidDots::dots() const {
  std::size_t n = 0;
  for (const BoardLay& lay : lays) n += static_cast<std::size_t>(lay.seen_B.cols());
  return n;
}

LayInformation lay_information(const LaidDots& laid, const FieldBasis& basis, double factor) {
  LayInformation told = told_by_board(laid, basis, factor);
  add(told_by_standards(laid, basis), told);
  return told;
}

std::optional<Refusal> doubt_of_turns(const LaidDots& board) {
  // A pattern that is turned by half a turn has the same aspect and shear, so turns count twice.
  constexpr double kLeastSpread = 10.0 * kDegree;
  std::complex<double> sum;
  for (const BoardLay& lay : board.lays) {
    const Eigen::Isometry2d pose =
        fit_rigid_2d(lay.seen_B, seen_scale({lay}) * centred(lay.p_board));
    const double turn = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
    sum += std::polar(1.0 / static_cast<double>(board.lays.size()), 2.0 * turn);
  }
  if (std::abs(sum) < std::cos(2.0 * kLeastSpread)) return std::nullopt;
  const std::string what =
      board.lays.size() == 1
          ? "there is one lay of the board; it"
          : fmt::format(
                "the {} lays of the board are only shifted, all turned by nearly the "
                "same angle; they",
                board.lays.size());
  return Refusal{what + " cannot tell a pattern that is printed askew from a picture that is bent",
                 "lay the board at other turns, too, some of them by 45 to 90 degrees", "lays",
                 Cause::kInsufficient};
}

}  // namespace planar
