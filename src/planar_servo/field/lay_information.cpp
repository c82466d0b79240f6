#include "planar_servo/field/lay_information.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>

#include "planar_servo/core/pose.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Deviation of a pitch called known, as a share of it: below a camera 1.5 m above dots whose
/// height a caliper tells to 0.03 mm.
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

using Columns3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// The dots of one lay, as equations z = field + pose . d_pose + shape . d_shape, in rows for x and
/// for y that have unit variance.
struct LayRows {
  Eigen::MatrixXd field;      ///< of x, and the same of y
  Columns3 pose_x, pose_y;    ///< shift x, shift y, turn
  Columns3 shape_x, shape_y;  ///< scale, aspect, shear
  Eigen::VectorXd z_x, z_y;
};

LayRows rows_of(const BoardLay& lay, double scale, const FieldBasis& basis, double factor) {
  const Eigen::Index n = lay.seen_B.cols();
  const Eigen::Matrix2Xd p_board = scale * centred(lay.p_board);
  const Eigen::Isometry2d pose = fit_rigid_2d(lay.seen_B, p_board);
  const Eigen::Matrix2Xd place = pose * p_board, arm = pose.linear() * p_board;
  Eigen::Matrix2Xd mirrored = p_board, swapped = p_board.colwise().reverse();
  mirrored.row(1) *= -1.0;
  mirrored = pose.linear() * mirrored;
  swapped = pose.linear() * swapped;
  LayRows rows{Eigen::MatrixXd(n, basis.terms()),
               Columns3(n, 3),
               Columns3(n, 3),
               Columns3(n, 3),
               Columns3(n, 3),
               Eigen::VectorXd(n),
               Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double weight = 1.0 / (factor * lay.sigma[i]);
    rows.field.row(i) = weight * basis.at(lay.seen_B.col(i));
    rows.pose_x.row(i) = weight * Eigen::RowVector3d(1.0, 0.0, -arm(1, i));
    rows.pose_y.row(i) = weight * Eigen::RowVector3d(0.0, 1.0, arm(0, i));
    rows.shape_x.row(i) = weight * Eigen::RowVector3d(arm(0, i), mirrored(0, i), swapped(0, i));
    rows.shape_y.row(i) = weight * Eigen::RowVector3d(arm(1, i), mirrored(1, i), swapped(1, i));
    rows.z_x[i] = weight * (lay.seen_B(0, i) - place(0, i));
    rows.z_y[i] = weight * (lay.seen_B(1, i) - place(1, i));
  }
  return rows;
}

/// Normal equations of the field's weights and the board's shape.
struct Sums {
  explicit Sums(Eigen::Index field_terms)
      : H(Eigen::MatrixXd::Zero(field_terms + 3, field_terms + 3)),
        right(Eigen::VectorXd::Zero(field_terms + 3)) {}

  Eigen::MatrixXd H;
  Eigen::VectorXd right;
  double squares{0.0};
};

/// Adds a lay, of which the pose is free: it takes its part of the squares away.
void add(const LayRows& rows, Sums& sums) {
  const Eigen::Index nb = rows.field.cols(), n = sums.right.size();
  const Eigen::MatrixXd of_component = rows.field.transpose() * rows.field;
  sums.H.topLeftCorner(nb, nb) += of_component;
  sums.H.block(nb, nb, nb, nb) += of_component;
  Columns3 with_shape(n, 3), with_pose(n, 3);
  with_shape << rows.field.transpose() * rows.shape_x, rows.field.transpose() * rows.shape_y,
      rows.shape_x.transpose() * rows.shape_x + rows.shape_y.transpose() * rows.shape_y;
  with_pose << rows.field.transpose() * rows.pose_x, rows.field.transpose() * rows.pose_y,
      rows.shape_x.transpose() * rows.pose_x + rows.shape_y.transpose() * rows.pose_y;
  sums.H.rightCols<3>() += with_shape;
  sums.H.bottomLeftCorner(3, n - 3) += with_shape.topRows(n - 3).transpose();
  Eigen::VectorXd right(n);
  right << rows.field.transpose() * rows.z_x, rows.field.transpose() * rows.z_y,
      rows.shape_x.transpose() * rows.z_x + rows.shape_y.transpose() * rows.z_y;
  const Eigen::Matrix3d of_pose =
      rows.pose_x.transpose() * rows.pose_x + rows.pose_y.transpose() * rows.pose_y;
  const Eigen::Vector3d right_of_pose =
      rows.pose_x.transpose() * rows.z_x + rows.pose_y.transpose() * rows.z_y;
  const Eigen::LDLT<Eigen::Matrix3d> pose(of_pose);
  sums.H -= with_pose * pose.solve(with_pose.transpose());
  sums.right += right - with_pose * pose.solve(right_of_pose);
  sums.squares += rows.z_x.squaredNorm() + rows.z_y.squaredNorm() -
                  right_of_pose.dot(pose.solve(right_of_pose));
}

}  // namespace

std::size_t LaidDots::dots() const {
  std::size_t n = 0;
  for (const BoardLay& lay : lays) n += static_cast<std::size_t>(lay.seen_B.cols());
  return n;
}

LayInformation lay_information(const LaidDots& board, const FieldBasis& basis, double factor) {
  const Eigen::Index n = 2 * basis.terms();
  const std::vector<BoardLay> lays = on_disc(board.lays, basis.radius);
  LayInformation told{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0.0, 0.0};
  if (lays.empty()) return told;
  const double scale = board.pitch_known ? 1.0 : seen_scale(lays);
  Sums sums(n);
  double numbers = 0.0;
  for (const BoardLay& lay : lays) {
    add(rows_of(lay, scale, basis, factor), sums);
    numbers += 2.0 * static_cast<double>(lay.seen_B.cols()) - 3.0;
  }
  const Eigen::Vector3d prior(board.pitch_known ? kKnownPitch : kUnknownPitch, kPrinted, kPrinted);
  Eigen::Matrix3d of_shape = sums.H.bottomRightCorner<3, 3>();
  of_shape.diagonal() += prior.cwiseAbs2().cwiseInverse();
  const Eigen::LDLT<Eigen::Matrix3d> shape(of_shape);
  const Columns3 with_shape = sums.H.topRightCorner(n, 3);
  const Eigen::Vector3d right_of_shape = sums.right.tail<3>();
  told.H = sums.H.topLeftCorner(n, n) - with_shape * shape.solve(with_shape.transpose());
  told.right = sums.right.head(n) - with_shape * shape.solve(right_of_shape);
  told.squares = sums.squares - right_of_shape.dot(shape.solve(right_of_shape));
  told.log_determinant = 2.0 * numbers * std::log(factor) + shape.vectorD().array().log().sum() +
                         2.0 * prior.array().log().sum();
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
                "the {} lays of the board are only shifted, all turned by nearly the same "
                "angle; they",
                board.lays.size());
  return Refusal{what + " cannot tell a pattern that is printed askew from a picture that is bent",
                 "lay the board at other turns, too, some of them by 45 to 90 degrees", "lays"};
}

}  // namespace planar
