#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

namespace planar {

/// The symmetric matrix A = [[K, Q], [Q^T, 0]] of kernel interpolation with a polynomial tail,
/// solved through the Cholesky factor K = L L^T. K (N x N) is positive definite; Q (N x m) has full
/// column rank and few columns or none.
class BorderedSystem {
 public:
  /// Factorizes A, reading only the lower triangle of `kernel`. Empty when K is not positive
  /// definite or Q has not full rank to working precision.
  static std::optional<BorderedSystem> factorize(const Eigen::MatrixXd& kernel,
                                                 const Eigen::MatrixXd& tail);

  struct Solution {
    Eigen::MatrixXd weights;  ///< N x c
    Eigen::MatrixXd tail;     ///< m x c
  };
  /// Solves A [weights; tail] = [values; 0] for N x c values.
  Solution solve(const Eigen::MatrixXd& values) const;
  /// Returns the first N elements of the diagonal of A^-1.
  Eigen::VectorXd inverse_diagonal() const;
  /// Returns the rows and columns `of` of A^-1; all are below N.
  Eigen::MatrixXd inverse_block(const std::vector<Eigen::Index>& of) const;
  /// Returns [k; q]^T A^-1 [k; q].
  double inverse_form(const Eigen::VectorXd& k, const Eigen::VectorXd& q) const;
  /// Returns (Q^T K^-1 Q)^-1, m x m: the covariance of the tail if K is that of the values.
  Eigen::MatrixXd tail_covariance() const;
  /// Returns the ratio of the smallest to the largest pivot of K. It bounds the reciprocal
  /// condition number from above and tells how much a sample adds to those before it.
  double pivot_ratio() const;

 private:
  Eigen::MatrixXd factor_;        ///< L
  Eigen::MatrixXd inverse_;       ///< L^-1
  Eigen::MatrixXd tail_;          ///< U = L^-1 Q
  Eigen::MatrixXd tail_factor_;   ///< G of U^T U = G G^T
  Eigen::MatrixXd tail_removed_;  ///< H = G^-1 U^T L^-1; A^-1 begins with K^-1 - H^T H
};

/// Positive definite functions of u = distance / width that are 1 at distance 0.
enum class KernelShape {
  kGaussian,      ///< exp(-u^2 / 2): one scale, infinitely smooth
  kMultiquadric,  ///< 1 - (sqrt(1 + u^2) - 1) / level: all scales from the width upwards
};

/// A kernel with its width. The multiquadric -sqrt(1 + u^2) alone is positive definite only for
/// weights that sum to 0, as a tail makes them. The level, a constant that does not change such
/// sums, makes it positive definite for all positions within `span` of each other.
struct RadialKernel {
  KernelShape shape{KernelShape::kGaussian};
  double width{0.0};  ///< metres
  double span{0.0};   ///< metres; only for the multiquadric

  double level() const;
};

/// Returns the diagonal of the positions' box, metres; one column per position.
double span_of(const Eigen::Matrix2Xd& positions);

/// Returns the squared distances between columns of `positions`; only the lower triangle is filled.
Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions);

/// Writes the kernel of each element of the lower triangle into that of `matrix`.
void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix);

/// Returns the kernel of the distance from p to each row of `centers`.
Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p);

/// The polynomial tail of a radial basis function map as a basis q(p) of scaled coordinates (p -
/// origin) / scale: degree 2 is [1, x, y, x^2, xy, y^2], degree 1 is [1, x, y], degree 0 is [1],
/// degree -1 is empty. With direction, the tool's d = (cos phi, sin phi) comes last; its
/// coefficients B represent an error fixed in the tool's frame, R(phi) t, and its mirror image.
struct TailBasis {
  int degree{1};
  Eigen::Vector2d origin{0.0, 0.0};  ///< metres
  double scale{1.0};                 ///< metres
  bool with_direction{false};

  Eigen::Index terms() const {
    return (degree + 1) * (degree + 2) / 2 + (with_direction ? kDirectionTerms : 0);
  }
  /// Returns q, of terms() elements. `direction` is used only by a basis that has it.
  Eigen::VectorXd at(const Eigen::Vector2d& p,
                     const Eigen::Vector2d& direction = unknown_direction()) const;
  /// Returns q of each column of `positions` and `directions`, one row each.
  Eigen::MatrixXd at_each(const Eigen::Matrix2Xd& positions,
                          const Eigen::Matrix2Xd& directions = {}) const;

  static constexpr Eigen::Index kDirectionTerms = 2;
  /// Returns NaN, which spreads to predictions that need a direction.
  static Eigen::Vector2d unknown_direction() {
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
};

/// Returns the tail about the middle of `positions` with the given degree, or the largest lower one
/// that the positions determine even with any one of them left out; few or collinear ones have no
/// slope. The tail has the direction if every position has one and they determine its terms. For
/// that the tool must turn by some ten degrees, independently of the position.
TailBasis tail_for(const Eigen::Matrix2Xd& positions, int degree = 1,
                   const Eigen::Matrix2Xd& directions = {});

/// Returns the tail about other positions with the terms of `basis` that they determine.
TailBasis tail_like(const TailBasis& basis, const Eigen::Matrix2Xd& positions,
                    const Eigen::Matrix2Xd& directions);

}  // namespace planar
