#include "planar_servo/experiment/experiment_prediction.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

/// Pairs on a grid whose error is a gentle wave, with the noise that their columns state.
CalibratedChain chain_with(double sigma_tracker, const MapMethodChoice& method) {
  CalibratedChain chain;
  chain.cell = read_cell(test::paper_cell_file());
  for (int i = -5; i <= 5; ++i)
    for (int j = -5; j <= 5; ++j) {
      PairRow pair;
      pair.id = std::to_string(100 * i + j);
      const Eigen::Vector2d p(0.09 * i, 0.09 * j);
      pair.p_tracker = p;
      const double noise = (i * 7 + j * 3) % 2 == 0 ? 5e-6 : -5e-6;
      pair.p_vision = p + Eigen::Vector2d(1e-4 * std::sin(4.0 * p.x()), noise);
      pair.sigma_vision = 4e-6;
      pair.sigma_tracker = sigma_tracker;
      chain.pairs.push_back(pair);
    }
  chain.map = fit_error_map_to_pairs(chain.pairs, method).result;
  return chain;
}

const std::vector<TargetRow> kTargets{{"a", {0.2, 0.1}, {}}, {"b", {-0.1, 0.3}, {}}};

TEST_CASE("No better positioning is predicted than the tracker's own standard deviation") {
  const PositioningPrediction with_10um =
      predict_positioning(chain_with(10e-6, {MapMethod::kRbf, 0.0}), kTargets);
  const PositioningPrediction with_50um =
      predict_positioning(chain_with(50e-6, {MapMethod::kRbf, 0.0}), kTargets);
  CHECK(with_10um.mean > 10e-6 * std::sqrt(kPi / 2.0));
  CHECK(with_10um.mean < 30e-6);
  CHECK(with_50um.mean > 50e-6 * std::sqrt(kPi / 2.0));
}

TEST_CASE("With one place the predicted 95 % is that of Rayleigh's distribution") {
  const PositioningPrediction prediction =
      predict_positioning(chain_with(10e-6, {MapMethod::kRbf, 0.0}), {kTargets[0]});
  CHECK(prediction.p95 / prediction.mean ==
        Approx(std::sqrt(-2.0 * std::log(0.05)) / std::sqrt(kPi / 2.0)));
}

TEST_CASE("A map without standard deviations lets nothing be predicted") {
  const PositioningPrediction prediction =
      predict_positioning(chain_with(10e-6, {MapMethod::kIdw, 0.0}), kTargets);
  CHECK(std::isnan(prediction.mean));
  CHECK(std::isnan(prediction.p95));
}

}  // namespace
}  // namespace planar
