#include "planar_servo/core/numerics/chance.h"

#include <cmath>
#include <stdexcept>

namespace planar {

// Q_k+2(x) = Q_k(x) + (x/2)^(k/2) exp(-x/2) / Gamma(k/2 + 1), from Q_1 or Q_2 [Abramowitz and
// Stegun 1964, 26.4.8].
double chi_square_tail(double square, int degrees) {
  if (degrees < 1) throw std::invalid_argument("no degree of freedom");
  if (square <= 0.0) return 1.0;
  const double half = 0.5 * square;
  double k = degrees % 2 == 0 ? 2.0 : 1.0;
  double tail = degrees % 2 == 0 ? std::exp(-half) : std::erfc(std::sqrt(half));
  for (; k < degrees; k += 2.0)
    tail += std::exp(0.5 * k * std::log(half) - half - std::lgamma(0.5 * k + 1.0));
  return tail;
}

double binomial_tail(int k, int n, double p) {
  double tail = 0.0;
  for (int i = 0; i <= k; ++i)
    tail += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                     i * std::log(p) + (n - i) * std::log1p(-p));
  return tail;
}

double f_tail_of_two(double ratio, double degrees) {
  return ratio <= 0.0 ? 1.0 : std::pow(1.0 + 2.0 * ratio / degrees, -0.5 * degrees);
}

}  // namespace planar
