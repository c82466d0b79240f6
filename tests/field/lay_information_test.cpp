#include "planar_servo/learn/field/lay_information.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "field/bent_cell.h"
#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kAllRound = 3.0;
const FieldBasis kBasis = basis_over_disc(0.6, 0.2);

/// Returns the weights of the field that the quadratic's x and y terms of p / radius make.
Eigen::VectorXd linear_field(const Eigen::Matrix2d& A) {
  const Eigen::Index nb = kBasis.terms();
  Eigen::MatrixXd at(200, nb);
  Eigen::MatrixX2d wanted(200, 2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d p = 0.5 * Eigen::Vector2d(std::sin(1.7 * i), std::cos(2.9 * i));
    at.row(i) = kBasis.at(p);
    wanted.row(i) = A * p;
  }
  const Eigen::Index quadratic = FieldBasis::kQuadratic;
  Eigen::MatrixX2d w = Eigen::MatrixX2d::Zero(nb, 2);
  const Eigen::MatrixXd tail = at.rightCols(quadratic);
  w.bottomRows(quadratic) = solve_symmetric(tail.transpose() * tail, tail.transpose() * wanted);
  return w.reshaped();
}

/// Returns how many standard deviations of the dots a field is off what they show, squared.
double sight_of(const LayInformation& told, const Eigen::VectorXd& w) {
  return w.dot(told.H * w);
}

Eigen::Matrix2d turn_of(double angle) {
  return (Eigen::Matrix2d() << 0.0, -angle, angle, 0.0).finished();
}

TEST_CASE("A board shows a field's bends and, with a known pitch, its scale, but never its turn") {
  const test::BentCell cell;
  std::mt19937 random(1);
  LaidDots board = cell.lays(6, kAllRound, 0.0, random);
  const LayInformation known = lay_information(board, kBasis, 1.0);
  board.pitch_known = false;
  for (BoardLay& lay : board.lays) lay.p_board /= 0.04;
  const LayInformation unknown = lay_information(board, kBasis, 1.0);
  constexpr double kLarge = 1e-3;  // as a share; a hundred times what a known pitch leaves open
  const Eigen::VectorXd turn = linear_field(turn_of(kLarge)),
                        scale = linear_field(kLarge * Eigen::Matrix2d::Identity());
  const Eigen::Vector2d bend(kLarge, -kLarge);
  const Eigen::VectorXd aspect = linear_field(bend.asDiagonal());
  CHECK(sight_of(known, turn) < 2.0);
  CHECK(sight_of(known, scale) > 2e3);
  CHECK(sight_of(unknown, scale) < 2.0);
  CHECK(sight_of(unknown, aspect) > 9e3);
}

TEST_CASE("What a board tells does not depend on where its dots are counted from") {
  const test::BentCell cell;
  std::mt19937 random(2);
  LaidDots board = cell.lays(4, kAllRound, 0.0, random);
  const LayInformation told = lay_information(board, kBasis, 1.0);
  for (BoardLay& lay : board.lays)
    lay.p_board = (rotation2d(0.7) * lay.p_board).colwise() + Eigen::Vector2d(0.3, -2.0);
  const LayInformation moved = lay_information(board, kBasis, 1.0);
  CHECK(moved.squares == Approx(told.squares).epsilon(1e-3));
  CHECK((moved.H - told.H).norm() < 1e-6 * told.H.norm());
}

TEST_CASE("Without a tracker a board and poses give the end point but for the turn") {
  const test::BentCell cell;
  constexpr int kPlaces = 200;
  std::mt19937 random(0);
  const auto samples = cell.samples(0, 120, random);
  const LampFieldFit fit =
      fit_lamp_field(cell.nominal(), samples, cell.lays(6, kAllRound, 2e-4, random));
  CHECK(fit.fixed_by.scale == FieldSource::kBoard);
  CHECK(fit.fixed_by.turn == FieldSource::kNothing);
  CHECK(fit.sources.size() == 2);
  double across = 0.0, squares = 0.0;
  Eigen::Matrix2Xd seen(2, kPlaces), off(2, kPlaces);
  for (int i = 0; i < kPlaces; ++i) {
    const PoseSample sample = cell.sample(test::BentCell::random_motors(random), false, random);
    seen.col(i) = compensate(fit.field, sample.lamps_B).tip.p;
    off.col(i) = seen.col(i) - cell.truth(sample.motors).tip;
    across += seen(0, i) * off(1, i) - seen(1, i) * off(0, i);
    squares += seen.col(i).squaredNorm();
  }
  off -= turn_of(across / squares) * seen;
  CHECK(std::abs(across / squares) > 1e-4);  // the turn is there to be taken out
  CHECK(off.colwise().norm().mean() < 6e-6);
}

TEST_CASE(
    "A bar shows a field's scale as far as its length is certain, and marks its turn and shift") {
  const test::BentCell cell;
  std::mt19937 random(4);
  constexpr double kLarge = 1e-4;  // ten times the bar's deviation as a share of its length
  const Eigen::VectorXd turn = linear_field(turn_of(kLarge)),
                        scale = linear_field(kLarge * Eigen::Matrix2d::Identity());
  LaidDots laid;
  cell.add_bar(laid, 0.0, random);
  const LayInformation bar = lay_information(laid, kBasis, 1.0);
  CHECK(sight_of(bar, scale) == Approx(100.0).epsilon(0.05));
  CHECK(sight_of(bar, turn) < 1e-6);
  laid.length_sigma = 5e-5;
  CHECK(sight_of(lay_information(laid, kBasis, 1.0), scale) == Approx(1.0).epsilon(0.05));
  laid.lengths.clear();
  cell.add_marks(laid, random);
  const LayInformation marks = lay_information(laid, kBasis, 1.0);
  CHECK(sight_of(marks, turn) > 1e3);
  CHECK(sight_of(marks, scale) > 1e3);
}

TEST_CASE("Without a tracker and a known pitch, bar and marks give the end point whole") {
  const test::BentCell cell;
  constexpr int kPlaces = 200;
  std::mt19937 random(0);
  const auto samples = cell.samples(0, 120, random);
  LaidDots laid = cell.lays(8, kAllRound, 2e-4, random);
  laid.pitch_known = false;
  for (BoardLay& lay : laid.lays) lay.p_board *= 1.02 / 0.04;
  cell.add_bar(laid, 3e-6, random);
  cell.add_marks(laid, random);
  const LampFieldFit fit = fit_lamp_field(cell.nominal(), samples, laid);
  CHECK(fit.fixed_by.scale == FieldSource::kBar);
  CHECK(fit.fixed_by.datum == FieldSource::kMarks);
  CHECK(fit.fixed_by.turn == FieldSource::kMarks);
  CHECK(fit.sources.size() == 4);
  double sum = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    const PoseSample sample = cell.sample(test::BentCell::random_motors(random), false, random);
    sum += (compensate(fit.field, sample.lamps_B).tip.p - cell.truth(sample.motors).tip).norm();
  }
  CHECK(sum / kPlaces < 8e-6);
  CHECK(fit.certainty.scale == Approx(1e-5).epsilon(0.5));
}

TEST_CASE("Lays that are only shifted are refused where no reading helps them") {
  const test::BentCell cell;
  std::mt19937 random(3);
  const LaidDots shifted = cell.lays(6, 0.1, 0.0, random);
  CHECK_THROWS_MATCHES(estimate_jointly(cell.nominal(), cell.samples(0, 40, random), shifted),
                       InputError, Refused(Cause::kInsufficient, "6 lays"));
  CHECK_NOTHROW(estimate_jointly(cell.nominal(), cell.samples(20, 40, random), shifted));
}

TEST_CASE("What marks and a bar tell beside shifted lamps is that of their common covariance") {
  LaidDots laid;
  laid.lamps_shift_sigma = 8e-6;
  laid.foot_B = {0.02, -0.03};
  laid.marks = {{{0.3, 0.1}, {0.30002, 0.1}, 3e-6},
                {{-0.2, 0.2}, {-0.2, 0.20001}, 5e-6},
                {{0.1, -0.4}, {0.10001, -0.4}, 4e-6}};
  laid.lengths = {{{Eigen::Vector2d(-0.2, -0.1), Eigen::Vector2d(0.2, 0.2)}, 2e-6},
                  {{Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(-0.2, 0.1)}, 3e-6}};
  laid.length = 0.49999;
  laid.length_sigma = 5e-6;
  const LayInformation told = lay_information(laid, kBasis, 1.0);
  constexpr int kRows = 8;  // x and y of the marks, lengths
  const Eigen::Index n = kBasis.terms();
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(kRows, 2 * n), common(kRows, 4);
  Eigen::VectorXd z(kRows), own(kRows);
  for (int i = 0; i < 6; ++i) {
    const MarkSight& mark = laid.marks[static_cast<std::size_t>(i / 2)];
    B.block(i, i % 2 * n, 1, n) = kBasis.at(mark.seen_B);
    common.row(i) << 0.0, i % 2 == 0, i % 2 == 1, (mark.seen_B - laid.foot_B)[i % 2];
    z[i] = (mark.seen_B - mark.p_B)[i % 2];
    own[i] = mark.sigma;
  }
  for (int i = 6; i < kRows; ++i) {
    const LengthSight& sight = laid.lengths[static_cast<std::size_t>(i - 6)];
    const Eigen::Vector2d way = sight.seen_B[1] - sight.seen_B[0];
    const Eigen::RowVectorXd growth = kBasis.at(sight.seen_B[1]) - kBasis.at(sight.seen_B[0]);
    B.row(i) << growth * way.x() / way.norm(), growth * way.y() / way.norm();
    common.row(i) << 1.0, 0.0, 0.0, way.norm();
    z[i] = way.norm() - laid.length;
    own[i] = sight.sigma;
  }
  const double half = std::pow(laid.lamps_shift_sigma, 2) / 2.0;
  const Eigen::Vector4d variances(std::pow(laid.length_sigma, 2), half, half,
                                  half / std::pow(kBasis.radius, 2));
  const Eigen::MatrixXd own_C = own.cwiseAbs2().asDiagonal();
  const Eigen::MatrixXd C = own_C + common * variances.asDiagonal() * common.transpose();
  const Eigen::MatrixXd weight = C.inverse(), H = B.transpose() * weight * B;
  const Eigen::VectorXd right = B.transpose() * weight * z;
  CHECK((told.H - H).norm() < 1e-6 * H.norm());
  CHECK((told.right - right).norm() < 1e-6 * right.norm());
  CHECK(told.squares == Approx(z.dot(weight * z)).epsilon(1e-6));
  CHECK(told.log_determinant ==
        Approx(std::log(C.determinant()) - std::log(own_C.determinant())).epsilon(1e-6));
}

}  // namespace
}  // namespace planar
