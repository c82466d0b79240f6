#include "planar_servo/run/target_scorer.h"

#include <catch2/catch.hpp>

#include "planar_servo/files/tables/step_table.h"

#include "support/temporary_folder.h"

namespace planar {
namespace {

ServoStep step_with(int iteration, const Eigen::Vector2d& error) {
  ServoStep step;
  step.iteration = iteration;
  step.error = error;
  return step;
}

TEST_CASE("A target's result counts the corrections and the time of all attempts") {
  const test::TemporaryFolder folder;
  GrowingFile steps(folder.path() / "steps.csv", steps_header());
  TargetScorer scorer({"A", {0.2, 0.1}, {}}, steps, {});
  scorer.observe(step_with(0, {1e-3, 0.0}));
  scorer.observe(step_with(1, {2e-4, 0.0}));
  scorer.observe(step_with(2, {5e-5, 0.0}));
  // The camera fails here; the second attempt begins with a move of its own.
  scorer.observe(step_with(0, {4e-5, 0.0}));
  scorer.observe(step_with(1, {1e-6, 0.0}));
  ServoResult last;
  last.status = ServoStatus::kReached;
  last.iterations = 1;
  last.duration_s = 1.5;
  const TargetResult result = scorer.finish(last, 21.0);
  CHECK(result.status == ServoStatus::kReached);
  CHECK(result.iterations == 3);
  CHECK(result.seconds == 21.0);
  CHECK(result.before_own->x() == -1e-3);
  CHECK(result.after_own->x() == -1e-6);
}

TEST_CASE("An end point is judged by the truth where there is one") {
  const test::TemporaryFolder folder;
  GrowingFile steps(folder.path() / "steps.csv", steps_header());
  const Eigen::Vector2d p_truth(0.2003, 0.1);
  TargetScorer scorer({"A", {0.2, 0.1}, {}}, steps, [&] { return TipPose{p_truth, 0.0}; });
  ServoStep step = step_with(0, {0.0, 0.0});
  step.measurement.p_vision = {0.201, 0.1};
  step.measurement.tip.p = {0.2, 0.1};
  scorer.observe(step);
  const TargetResult result = scorer.finish({}, 1.0);
  constexpr double kRounding_m = 1e-15;
  CHECK((*result.after_truth - Eigen::Vector2d(3e-4, 0.0)).norm() < kRounding_m);
  CHECK((*result.vision_raw - Eigen::Vector2d(7e-4, 0.0)).norm() < kRounding_m);
  CHECK((*result.vision_compensated - Eigen::Vector2d(-3e-4, 0.0)).norm() < kRounding_m);
}

}  // namespace
}  // namespace planar
