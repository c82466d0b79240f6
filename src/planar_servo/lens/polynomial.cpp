#include "planar_servo/lens/polynomial.h"

#include <algorithm>

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

}  // namespace

Polynomial polynomial(std::initializer_list<double> coefficients) {
  Polynomial result(static_cast<Eigen::Index>(coefficients.size()));
  std::copy(coefficients.begin(), coefficients.end(), result.data());
  return result;
}

double value(const Polynomial& a, double s) {
  double sum = 0.0;
  for (Eigen::Index i = a.size() - 1; i >= 0; --i) sum = sum * s + a[i];
  return sum;
}

Polynomial derivative(const Polynomial& a) {
  Polynomial result(std::max<Eigen::Index>(1, a.size() - 1));
  result.setZero();
  for (Eigen::Index i = 1; i < a.size(); ++i) {
    result[i - 1] = static_cast<double>(i) * a[i];
  }
  return result;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result = Polynomial::Zero(a.size() + b.size() - 1);
  for (Eigen::Index i = 0; i < a.size(); ++i) result.segment(i, b.size()) += a[i] * b;
  return result;
}

bool positive_up_to(double end, const Polynomial& a) {
  return positive(bernstein_coefficients(end, a), kSubdivisions);
}

}  // namespace planar::lens
