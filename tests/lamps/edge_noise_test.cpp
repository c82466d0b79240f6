#include "planar_servo/lamps/paper_center.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

namespace planar {
namespace {

constexpr std::size_t kEdges = 20000;
constexpr double kEstimate = 0.1;  // of a correlation summed over a few lags of so many edges

/// Sliding means of `width` normal values round a closed rim, in disorder.
std::vector<EdgeResidual> residuals(std::size_t width) {
  std::mt19937 random(50);
  std::normal_distribution<double> normal;
  std::vector<double> values(kEdges);
  for (double& value : values) value = normal(random);
  std::vector<EdgeResidual> result;
  for (std::size_t i = 0; i < kEdges; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < width; ++k) sum += values[(i + k) % kEdges];
    result.push_back({1e-4 * static_cast<double>(i), sum / static_cast<double>(width)});
  }
  std::shuffle(result.begin(), result.end(), random);
  return result;
}

TEST_CASE("edges_per_independent is one for independent edges") {
  CHECK(edges_per_independent(residuals(1), 6) == Approx(1.0).margin(kEstimate));
}

TEST_CASE("edges_per_independent counts the edges of a sliding mean, less the taper's loss") {
  // 1 + 2 sum_k (1 - k / 21) (1 - k / 4) for k = 1 to 3: 4 without the taper.
  CHECK(edges_per_independent(residuals(4), 20) == Approx(3.7619).epsilon(kEstimate));
}

TEST_CASE("edges_per_independent of exact edges is one") {
  CHECK(edges_per_independent({{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}}, 6) == 1.0);
  CHECK(edges_per_independent({}, 6) == 1.0);
}

}  // namespace
}  // namespace planar
