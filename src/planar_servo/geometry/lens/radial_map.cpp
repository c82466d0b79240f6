#include "planar_servo/geometry/lens/radial_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace planar::lens {
namespace {

constexpr int kSubdivisions = 20;

/// Returns the Bernstein coefficients on [0, end]: b_j = sum over i <= j of
/// C(j, i) / C(n, i) a_i end^i.
Polynomial bernstein_coefficients(double end, const Polynomial& a) {
  const Eigen::Index n = a.size() - 1;
  // Repeated sums of a_i end^i / C(n, i) build the binomials C(j, i).
  Polynomial b = a;
  double scale = 1.0;
  for (Eigen::Index i = 1; i <= n; ++i) {
    scale *= end * static_cast<double>(i) / static_cast<double>(n - i + 1);
    b[i] *= scale;
  }
  for (Eigen::Index round = 0; round < n; ++round) {
    for (Eigen::Index j = n; j > round; --j) b[j] += b[j - 1];
  }
  return b;
}

bool positive(const Polynomial& b, int subdivisions_left) {
  const Eigen::Index n = b.size() - 1;
  if (!(b[0] > 0.0) || !(b[n] > 0.0)) return false;
  if ((b.array() > 0.0).all()) return true;
  if (subdivisions_left == 0) return false;
  // De Casteljau's algorithm splits the interval in the middle: `right` ends as the right half's
  // coefficients.
  Polynomial left = b;
  Polynomial right = b;
  for (Eigen::Index round = 1; round <= n; ++round) {
    for (Eigen::Index j = 0; j <= n - round; ++j) right[j] = 0.5 * (right[j] + right[j + 1]);
    left[round] = right[0];
  }
  return positive(left, subdivisions_left - 1) && positive(right, subdivisions_left - 1);
}

constexpr int kNewtonSteps = 50;
/// Residual of the inverse in normalised units: a billionth of a pixel at common focal lengths.
constexpr double kInverseTolerance = 1e-13;

Polynomial derivative(const Polynomial& a) {
  Polynomial result(std::max<Eigen::Index>(1, a.size() - 1));
  result.setZero();
  for (Eigen::Index i = 1; i < a.size(); ++i) result[i - 1] = static_cast<double>(i) * a[i];
  return result;
}

/// Returns N D + 2 s (N' D - N D').
Polynomial growth_of(const Polynomial& N, const Polynomial& D) {
  Polynomial growth = Polynomial::Zero(N.size() + D.size() - 1);
  for (Eigen::Index i = 0; i < N.size(); ++i)
    for (Eigen::Index j = 0; j < D.size(); ++j)
      growth[i + j] += static_cast<double>(1 + 2 * (i - j)) * N[i] * D[j];
  return growth;
}

/// Adds the lateral terms of the point `xy`, with s = |xy|^2, to a mapping.
void add_lateral(const LateralTerms& c, const Eigen::Vector2d& xy, double s, Mapped& mapped) {
  const double x = xy.x();
  const double y = xy.y();
  mapped.xy += Eigen::Vector2d(2.0 * c.p1 * x * y + c.p2 * (s + 2.0 * x * x),
                               c.p1 * (s + 2.0 * y * y) + 2.0 * c.p2 * x * y);
  const double mixed = 2.0 * (c.p1 * x + c.p2 * y);
  Eigen::Matrix2d decentring;
  decentring << 2.0 * c.p1 * y + 6.0 * c.p2 * x, mixed, mixed, 6.0 * c.p1 * y + 2.0 * c.p2 * x;
  mapped.J += decentring;

  const Eigen::Vector2d first(c.s1, c.s3);
  const Eigen::Vector2d second(c.s2, c.s4);
  mapped.xy += s * first + s * s * second;
  mapped.J += 2.0 * (first + 2.0 * s * second) * xy.transpose();
}

}  // namespace

Polynomial polynomial(std::initializer_list<double> coefficients) {
  return Eigen::Map<const Polynomial>(coefficients.begin(),
                                      static_cast<Eigen::Index>(coefficients.size()));
}

double value(const Polynomial& a, double s) {
  double sum = 0.0;
  for (Eigen::Index i = a.size() - 1; i >= 0; --i) sum = sum * s + a[i];
  return sum;
}

bool positive_up_to(double end, const Polynomial& a) {
  double least = a[0], power = 1.0;  // by the negative terms alone
  for (Eigen::Index i = 1; i < a.size(); ++i) {
    power *= end;
    least += std::min(a[i], 0.0) * power;
  }
  return least > 0.0 || positive(bernstein_coefficients(end, a), kSubdivisions);
}

RadialMap::RadialMap(const Polynomial& numerator, const Polynomial& denominator,
                     const LateralTerms& lateral)
    : numerator_(numerator),
      denominator_(denominator),
      growth_(growth_of(numerator, denominator)),
      lateral_(lateral) {}

std::optional<Mapped> RadialMap::distort(const Eigen::Vector2d& xy) const {
  const double s = xy.squaredNorm();
  if (!positive_up_to(s, denominator_) || !positive_up_to(s, growth_)) return std::nullopt;

  const double N = value(numerator_, s);
  const double D = value(denominator_, s);
  const double scale = N / D;
  const double d_scale_d_s =
      (value(derivative(numerator_), s) - scale * value(derivative(denominator_), s)) / D;

  Mapped mapped{scale * xy,
                scale * Eigen::Matrix2d::Identity() + 2.0 * d_scale_d_s * xy * xy.transpose()};
  add_lateral(lateral_, xy, s, mapped);
  if (!(mapped.J.determinant() > 0.0) || !mapped.xy.allFinite()) return std::nullopt;
  return mapped;
}

std::optional<Mapped> RadialMap::undistort(const Eigen::Vector2d& xy_d) const {
  if (!std::isfinite(xy_d.norm())) return std::nullopt;  // nor where its square is too large
  const double tolerance = kInverseTolerance * std::max(1.0, xy_d.norm());
  Eigen::Vector2d xy{0.0, 0.0};
  std::optional<Mapped> at = distort(xy);
  for (int step = 0; step < kNewtonSteps && at; ++step) {
    const Eigen::Vector2d missing = xy_d - at->xy;
    if (missing.norm() <= tolerance) return Mapped{xy, at->J.inverse()};
    const Eigen::Vector2d full_step = at->J.inverse() * missing;
    std::optional<Mapped> next;
    for (double fraction = 1.0; !next && fraction > 1e-6; fraction *= 0.5) {
      const Eigen::Vector2d tried = xy + fraction * full_step;
      next = distort(tried);
      if (next && (xy_d - next->xy).norm() >= missing.norm()) next.reset();
      if (next) xy = tried;
    }
    at = next;
  }
  return std::nullopt;
}

}  // namespace planar::lens
