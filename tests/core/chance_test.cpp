#include "planar_servo/base/core/statistics.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace planar {
namespace {

TEST_CASE("The tail of chi square is that of the tables") {
  CHECK(chi_square_tail(10.828, 1) == Approx(1e-3).epsilon(1e-3));
  CHECK(chi_square_tail(13.816, 2) == Approx(1e-3).epsilon(1e-3));
  CHECK(chi_square_tail(16.266, 3) == Approx(1e-3).epsilon(1e-3));
  CHECK(chi_square_tail(27.877, 9) == Approx(1e-3).epsilon(1e-3));
  CHECK(chi_square_tail(18.307, 10) == Approx(0.05).epsilon(1e-3));
  CHECK(chi_square_tail(0.0, 4) == 1.0);
  CHECK_THROWS_AS(chi_square_tail(1.0, 0), std::invalid_argument);
}

TEST_CASE("The chance of few successes is the binomial distribution's") {
  CHECK(binomial_tail(5, 10, 0.5) == Approx(0.623046875));
  CHECK(binomial_tail(70, 100, 0.8) == Approx(0.0112489787));
  CHECK(binomial_tail(100, 100, 0.8) == Approx(1.0));
  CHECK(binomial_tail(0, 3, 0.25) == Approx(0.421875));
}

}  // namespace
}  // namespace planar
