#include "planar_servo/learn/error_map/compare_methods.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/error_fields.h"

namespace planar {
namespace {

std::vector<ErrorSample> samples_on(const std::vector<Eigen::Vector2d>& positions) {
  return test::measure(test::glow_field, positions, test::kFieldNoise, 1);
}

TEST_CASE("Methods are compared on the pairs that the fit kept") {
  MapProblem problem{samples_on(test::ring_positions(100))};
  problem.samples[3].error.x() += 1e-3;
  const MapResult result = fit_error_map(problem);
  REQUIRE(result.rejected.size() == 1);
  const auto rows = compare_methods(problem, result);
  REQUIRE(rows.size() == 5);
  const std::vector<std::string> names{"raw", "idw", "hand:48", "rbf", "auto"};
  for (std::size_t i = 0; i < rows.size(); ++i) CHECK(rows[i].method == names[i]);
  CHECK(rows[0].loo_rms == Approx(result.raw_rms));
  CHECK(rows[1].loo_rms == Approx(result.idw_loo_rms));
  CHECK(rows[4].loo_rms == result.loo_rms);
  CHECK(rows[4].blocked.value == result.blocked.value);
  CHECK(rows[4].loo_rms < rows[2].loo_rms);
  CHECK(rows[3].blocked.value < rows[0].blocked.value);
}

TEST_CASE("A fit by one method is beside the others what it would be alone") {
  const auto samples = samples_on(test::ring_positions(60));
  const MapProblem by_hand{samples, MapMethod::kHandWidth, 0.060};
  const MapProblem by_rbf{samples, MapMethod::kRbf};
  const auto rows = compare_methods(by_hand, fit_error_map(by_hand));
  CHECK(rows[2].method == "hand:60");
  CHECK(rows[3].loo_rms == Approx(fit_error_map(by_rbf).loo_rms).epsilon(0.01));
}

TEST_CASE("A width whose equations cannot be solved is a row without figures") {
  auto positions = test::random_positions(200, 1);
  for (Eigen::Vector2d& p : positions) p *= 0.2;  // a disc of two such widths
  const MapProblem problem{samples_on(positions), MapMethod::kRbf};
  const auto rows = compare_methods(problem, fit_error_map(problem));
  CHECK(std::isnan(rows[2].loo_rms));
  CHECK(std::isnan(rows[2].blocked.value));
  CHECK(std::isfinite(rows[4].loo_rms));
}

TEST_CASE("Beyond a thousand positions only the fit itself is compared with no map") {
  const MapProblem problem{samples_on(test::random_positions(1200, 1))};
  const auto rows = compare_methods(problem, fit_error_map(problem));
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].method == "raw");
  CHECK(rows[1].method == "auto");
}

}  // namespace
}  // namespace planar
