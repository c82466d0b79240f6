#include "planar_servo/work/run/servo_run.h"

#include <catch2/catch.hpp>

#include "planar_servo/files/tables/result_table.h"

#include "support/temporary_folder.h"

namespace planar {
namespace {

const SteadyClock kClock;

ServoStep step_with(int iteration, const Eigen::Vector2d& error) {
  ServoStep step;
  step.iteration = iteration;
  step.error = error;
  return step;
}

/// Judges every look at the next of some places.
class JudgeOfPlaces final : public Judge {
 public:
  JudgeOfPlaces(JudgeKind kind, const std::vector<JudgedTip>& places)
      : kind_(kind), places_(places) {}

  int asked{0};

  JudgeKind kind() const override { return kind_; }
  JudgedTip judge(const std::string& /*id*/, const Standing& /*standing*/) override {
    return places_.at(asked++);
  }
  double common_sigma() const override { return 0.0; }

 private:
  JudgeKind kind_;
  std::vector<JudgedTip> places_;
};

TEST_CASE("A target's result counts the corrections and the time of all attempts") {
  const test::TemporaryFolder folder;
  GrowingFile steps(folder.path() / "steps.csv", steps_header());
  TargetScorer scorer({"A", {0.2, 0.1}, {}}, &steps, nullptr, kClock);
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
  JudgeOfPlaces truth(JudgeKind::kTruth, {{p_truth, 0.0, ""}});
  TargetScorer scorer({"A", {0.2, 0.1}, {}}, &steps, &truth, kClock);
  ServoStep step = step_with(0, {0.0, 0.0});
  step.measurement.p_vision = {0.201, 0.1};
  step.measurement.tip.p = {0.2, 0.1};
  step.measurement.uncertainty_m = 9e-6;
  step.estimate = LandingEstimate{};
  step.estimate->p = {0.2001, 0.1};
  step.estimate->deviation_m = 4e-6;
  scorer.observe(step);
  const TargetResult result = scorer.finish({}, 1.0);
  constexpr double kRounding_m = 1e-15;
  CHECK((*result.after_judged - Eigen::Vector2d(3e-4, 0.0)).norm() < kRounding_m);
  CHECK((*result.vision_raw - Eigen::Vector2d(7e-4, 0.0)).norm() < kRounding_m);
  CHECK((*result.vision_compensated - Eigen::Vector2d(-3e-4, 0.0)).norm() < kRounding_m);
  CHECK((*result.believed - Eigen::Vector2d(-2e-4, 0.0)).norm() < kRounding_m);
  CHECK(result.uncertainty_m == 4e-6);
}

ServoResult ended(ServoStatus status) {
  ServoResult last;
  last.status = status;
  return last;
}

ServoStep seen_step(int iteration) {
  ServoStep step = step_with(iteration, {1e-3, 0.0});
  step.measurement.p_vision = {0.2005, 0.1};
  step.measurement.tip.p = {0.2001, 0.1};
  return step;
}

TEST_CASE("A judge is asked at the first look and at the end, once where the arm did not move on") {
  const test::TemporaryFolder folder;
  GrowingFile steps(folder.path() / "steps.csv", steps_header());
  constexpr double kRounding_m = 1e-15;
  SECTION("a target that needs a correction") {
    JudgeOfPlaces at(JudgeKind::kTracker, {{Eigen::Vector2d(0.203, 0.1), 1e-5, ""},
                                           {Eigen::Vector2d(0.2, 0.1004), 2e-5, ""}});
    TargetScorer scorer({"A", {0.2, 0.1}, {}}, &steps, &at, kClock);
    scorer.observe(seen_step(0));
    scorer.observe(seen_step(1));
    const TargetResult result = scorer.finish(ended(ServoStatus::kReached), 1.0);
    CHECK(at.asked == 2);
    CHECK((*result.before_judged - Eigen::Vector2d(3e-3, 0.0)).norm() < kRounding_m);
    CHECK((*result.after_judged - Eigen::Vector2d(0.0, 4e-4)).norm() < kRounding_m);
    CHECK(result.sigma_judged_m == 2e-5);
    CHECK((*result.vision_raw - Eigen::Vector2d(5e-4, -4e-4)).norm() < kRounding_m);
    CHECK((*result.vision_compensated - Eigen::Vector2d(1e-4, -4e-4)).norm() < kRounding_m);
  }
  SECTION("a target that is reached at once") {
    JudgeOfPlaces at(JudgeKind::kTracker, {{Eigen::Vector2d(0.203, 0.1), 1e-5, ""}});
    TargetScorer scorer({"A", {0.2, 0.1}, {}}, &steps, &at, kClock);
    scorer.observe(seen_step(0));
    const TargetResult result = scorer.finish(ended(ServoStatus::kReached), 1.0);
    CHECK(at.asked == 1);
    CHECK(result.after_judged == result.before_judged);
  }
}

TEST_CASE("A target that nobody could judge says why and has no true error") {
  const test::TemporaryFolder folder;
  GrowingFile steps(folder.path() / "steps.csv", steps_header());
  JudgeOfPlaces at(JudgeKind::kTracker, {{{}, 0.0, "a broken beam"}, {{}, 0.0, "a broken beam"}});
  TargetScorer scorer({"A", {0.2, 0.1}, {}}, &steps, &at, kClock);
  TargetResult result;
  SECTION("the beam is broken") {
    scorer.observe(seen_step(0));
    scorer.observe(seen_step(1));
    result = scorer.finish(ended(ServoStatus::kReached), 1.0);
    CHECK(result.not_judged == "a broken beam");
  }
  SECTION("the arm was never there") {
    result = scorer.finish(ended(ServoStatus::kRefused), 1.0);
    CHECK_THAT(result.not_judged, Catch::Contains("did not arrive"));
    CHECK(at.asked == 0);
  }
  CHECK_FALSE(result.after_judged);
  CHECK_FALSE(result.before_judged);
}

}  // namespace
}  // namespace planar
