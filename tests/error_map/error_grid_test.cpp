#include "planar_servo/learn/error_map/error_grid.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kSigma = 3e-6;
constexpr double kRounding = 1e-12;

/// A field over a square of 0.4 m, or a disc, with one deviation everywhere.
ErrorField field_over(std::vector<Eigen::Vector2d> hull,
                      std::function<Eigen::Vector2d(const Eigen::Vector2d&)> error) {
  const ValidRegion region{std::move(hull), 0.0};
  return {[=](const Eigen::Vector2d& p) {
            return ErrorPrediction{error(p), kSigma, region.contains(p)};
          },
          error, region};
}

const std::vector<Eigen::Vector2d> kSquare{{-0.2, -0.2}, {0.2, -0.2}, {0.2, 0.2}, {-0.2, 0.2}};

std::vector<Eigen::Vector2d> disc(double radius) {
  std::vector<Eigen::Vector2d> hull;
  for (int i = 0; i < 60; ++i)
    hull.emplace_back(radius * std::cos(0.1047198 * i), radius * std::sin(0.1047198 * i));
  return hull;
}

TEST_CASE("A grid is as coarse as a tenth of the deviation allows") {
  constexpr double kCurvature = 0.01;
  const ErrorField bowl = field_over(kSquare, [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(kCurvature * p.x() * p.x(), 0.0);
  });
  const SampledError found = sample_error(bowl);
  const double step = found.grid.step;
  CHECK(found.interpolation_max == Approx(kCurvature * step * step / 4.0).epsilon(1e-6));
  CHECK(found.interpolation_share == Approx(found.interpolation_max / kSigma));
  CHECK(found.interpolation_share <= kInterpolationShare);
  CHECK(found.interpolation_share > 0.5 * kInterpolationShare);
  CHECK(found.sigma_min == kSigma);
  CHECK(found.grid.inside.count() > found.grid.nodes() / 2);
}

TEST_CASE("A step that is too coarse, and an error that no grid holds, are refused") {
  const ErrorField waves = field_over(kSquare, [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(1e-5 * std::sin(p.x() / 1e-3), 0.0);
  });
  CHECK_THROWS_MATCHES(sample_error(waves, 0.02), InputError,
                       Refused(Cause::kInvalid, "a step of 20 mm"));
  const ErrorField noise = field_over(kSquare, [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(1e-3 * std::sin(p.x() / 1e-6), 0.0);
  });
  CHECK_THROWS_MATCHES(sample_error(noise), InputError, Refused(Cause::kInvalid, "100000"));
  ErrorField unstated = waves;
  unstated.predict = [](const Eigen::Vector2d&) {
    return ErrorPrediction{{0.0, 0.0}, std::nan(""), true};
  };
  unstated.sigma_if_unstated = std::nan("");
  CHECK_THROWS_MATCHES(sample_error(unstated), InputError, Refused(Cause::kMissing));
  CHECK_THROWS_MATCHES(sample_error(field_over({}, waves.error)), InputError,
                       Refused(Cause::kInvalid, "hull"));
}

TEST_CASE("A grid is fine enough to have nodes in a narrow region, and ends where none can") {
  const auto zero = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  ErrorField line = field_over({{-0.2, -0.2004}, {0.2, 0.1996}}, zero);
  line.region.margin = 0.003;
  const ValidRegion region = line.region;
  line.predict = [region](const Eigen::Vector2d& p) {
    return ErrorPrediction{{0.0, 0.0}, kSigma, region.contains(p)};
  };
  const ErrorGrid grid = sample_error(line).grid;
  CHECK(grid.inside.count() > 4);
  CHECK(grid.step <= 0.025);
  const double huge = 1.7e308;
  CHECK_THROWS_MATCHES(sample_error(field_over({{-huge, 0.0}, {huge, 0.0}, {0.0, huge}}, zero)),
                       InputError, Refused(Cause::kInvalid, "100000"));
}

TEST_CASE("Where the field states no deviation the given one is taken, and the grid has none") {
  ErrorField field = field_over(kSquare, [](const Eigen::Vector2d& p) { return 1e-3 * p; });
  field.predict = [](const Eigen::Vector2d& p) {
    return ErrorPrediction{1e-3 * p, std::nan(""), true};
  };
  field.sigma_if_unstated = 2e-5;
  const SampledError found = sample_error(field);
  CHECK(found.sigma_median == 2e-5);
  CHECK(found.grid.sigmas.array().isNaN().all());
}

TEST_CASE("Far beyond the valid region a grid holds the error at its edge") {
  const ErrorField steep = field_over(disc(0.2), [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(0.01 * p.squaredNorm(), 0.0);
  });
  const ErrorGrid grid = sample_error(steep).grid;
  const double edge = 0.2 + 1.5 * grid.step;
  CHECK_FALSE(grid.inside[0]);
  CHECK(grid.node(0).norm() > edge + grid.step);
  CHECK(grid.errors.row(0).maxCoeff() == Approx(0.01 * edge * edge).epsilon(0.01));
}

TEST_CASE("Over true places the error is that of the place seen there") {
  const ErrorField seen = field_over(disc(0.2), [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(0.02 * p.x() + 0.1 * p.y() * p.y(), 0.001 - 0.05 * p.x() * p.y());
  });
  const ErrorField over_true = over_true_places(seen);
  for (const Eigen::Vector2d& p : disc(0.15)) {
    const Eigen::Vector2d error = over_true.error(p);
    CHECK((seen.error(p + error) - error).norm() < 1e-9);
    CHECK((over_true.predict(p).error - error).norm() < kRounding);
    CHECK(over_true.predict(p).inside);
  }
  const ErrorField torn = over_true_places(
      field_over(kSquare, [](const Eigen::Vector2d& p) { return Eigen::Vector2d(-3.0 * p); }));
  CHECK_THROWS_MATCHES(torn.error({0.1, 0.1}), WorkError,
                       Refused(Cause::kInsufficient, "(100.0, 100.0) mm"));
}

TEST_CASE("A grid without noise, written with few decimals, is no faulty recording") {
  MapProblem problem;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) {
      const Eigen::Vector2d p_mm(-200.0 + 50.0 * i, 100.0 + 40.0 * j);
      const Eigen::Vector2d error_mm(0.05 + 1e-4 * p_mm.x() - 2e-4 * p_mm.y(),
                                     -0.03 + 3e-4 * p_mm.x() + 1e-4 * p_mm.y());
      ErrorSample sample;
      sample.p_vision = kMillimetre * p_mm;
      sample.error = kMillimetre * (1000.0 * error_mm).array().round().matrix() / 1000.0;
      problem.samples.push_back(sample);
    }
  const MapResult map = fit_error_map(problem);
  CHECK(map.at_places.residuals.cwiseAbs().maxCoeff() < 1e-12);
  CHECK(map.coverage_95 == 1.0);
  CHECK(map.at_places.sigmas.minCoeff() == Approx(1e-6 / std::sqrt(12.0)));
  CHECK_FALSE(objection(map.quality()));
}

}  // namespace
}  // namespace planar
