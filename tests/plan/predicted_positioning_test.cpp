#include "planar_servo/offline/plan/predicted_positioning.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

/// A cell whose field is certain, but for the end point's offset from the lamps.
PredictionInputs known_cell(double sigma_tip) {
  LampField field;
  field.basis = basis_over_disc(0.6, 0.3);
  field.weights.setZero(field.basis.terms(), 2);
  const Eigen::Index n = field.unknowns();
  field.factor.setZero(n, n);
  field.factor(n - 2, n - 2) = field.factor(n - 1, n - 1) = sigma_tip;
  const Pinhole camera{{1000.0, 1000.0, 500.0, 500.0}};
  PredictionInputs known{{{0.04, {0.008, 0.008}}, {camera, Pose::Identity()}, {}, field}, {}, {}};
  known.servo.tolerance_m = 5e-6;
  return known;
}

const std::vector<TargetRow> kTargets{{"a", {0.2, 0.1}, {}}, {"b", {-0.1, 0.3}, {}}};
const double kMeanLength = std::sqrt(kPi / 2.0);

TEST_CASE("Variances of field, vision and landing add up") {
  PredictionInputs known = known_cell(3e-6);
  known.landing_sigma = 1e-6;
  known.sigma_vision = 2e-6;
  CHECK(predict_positioning(known, kTargets).mean ==
        Approx(kMeanLength * std::sqrt(9.0 + 1.0 + 4.0) * 1e-6));
}

TEST_CASE("An arm that lands beside the tolerance is content within it") {
  PredictionInputs known = known_cell(0.0);
  known.landing_sigma = 1e-3;
  CHECK(predict_positioning(known, kTargets).mean == Approx(kMeanLength * 2.5e-6));
}

TEST_CASE("Monuments leave a turn that grows with the distance from the base") {
  PredictionInputs known = known_cell(0.0);
  known.sigma_tracker = 10e-6;
  for (const double x : {-0.4, 0.4}) known.datum.push_back({"", {x, 0.0, 0.0}});
  const double turn = 10e-6 / std::sqrt(5.0 * 2.0 * 0.16);
  CHECK(positioning_terms(known, kTargets[0]).datum == 0.0);  // the field's covariance has it
  known.vision.error_map.reset();
  const auto mean_at = [&](double x) {
    return predict_positioning(known, {{"a", {x, 0.0}, {}}}).mean;
  };
  CHECK(mean_at(0.1) == Approx(kMeanLength * 0.1 * turn));
  CHECK(mean_at(0.3) == Approx(3.0 * mean_at(0.1)));
  known.monument_readings = 1;
  CHECK(mean_at(0.1) == Approx(kMeanLength * 0.1 * std::sqrt(5.0) * turn));
}

TEST_CASE("With one place the predicted 95 % is that of Rayleigh's distribution") {
  const PositioningPrediction prediction = predict_positioning(known_cell(2e-6), {kTargets[0]});
  CHECK(prediction.p95 / prediction.mean == Approx(std::sqrt(-2.0 * std::log(0.05)) / kMeanLength));
}

}  // namespace
}  // namespace planar
