#include "planar_servo/certificate/uncertainty_budget.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/files/calibration_files.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

/// A cell, its vision, and a run of one target whose error is 10 um.
struct SampleRun {
  CellSettings cell{read_cell(test::workshop_cell_file())};
  VisionCalibration vision{read_vision(cell, true)};
  std::vector<JudgedMove> moves;

  SampleRun() {
    JudgedMove& move = moves.emplace_back();
    move.move.part = CertificatePart::kWorkspace;
    move.move.p_d = {0.3, 0.1};
    move.status = ServoStatus::kReached;
    move.error = {6e-6, 8e-6};
    move.landing_own = {1e-3, 1e-3};
    move.sigma_vision = 3e-6;
    move.stop_below = 8e-6;
  }
  UncertaintyBudget budget(const CellAccuracy& accuracy) const {
    return uncertainty_budget(cell, vision, moves, accuracy);
  }
  const UncertaintyBudget budget() const { return budget(cell_accuracy(moves)); }
};

const BudgetTerm& term(const UncertaintyBudget& budget, const std::string& name) {
  for (const BudgetTerm& candidate : budget.terms)
    if (candidate.name().rfind(name, 0) == 0) return candidate;
  throw std::out_of_range(name);
}

TEST_CASE("Every term is what files and run say") {
  const SampleRun run;
  const UncertaintyBudget budget = run.budget();
  CHECK(term(budget, "lamps").sigma == Approx(3e-6));
  CHECK(term(budget, "field").sigma ==
        Approx(predict_error_at(run.vision, {{0.3, 0.1}, 0.0}).sigma));
  CHECK(term(budget, "stop").sigma == Approx(4e-6));
  CHECK(term(budget, "arm").sigma == Approx(1e-3));
  CHECK(term(budget, "tracker").sigma > 0.0);
  CHECK(term(budget, "drift").sigma == 0.0);
  CHECK(budget.found == Approx(10e-6));
}

TEST_CASE("The root sum of squares leaves out what another term holds") {
  const UncertaintyBudget budget = SampleRun().budget();
  CHECK_FALSE(term(budget, "plane").counts);
  CHECK_FALSE(term(budget, "arm").counts);  // it is corrected down to the stop rule
  double sum = 0.0;
  for (const char* name : {"lamps", "field", "tracker", "stop"})
    sum += std::pow(term(budget, name).sigma, 2);
  CHECK(budget.expected == Approx(std::sqrt(2.0 * sum)));
  CHECK(budget.expected_without(term(budget, "stop")) == Approx(std::sqrt(2.0 * (sum - 16e-12))));
}

TEST_CASE("An arm that lands within the stop rule counts in its place") {
  SampleRun run;
  run.moves[0].landing_own = {1e-6, 1e-6};
  const UncertaintyBudget budget = run.budget();
  CHECK(term(budget, "arm").counts);
  CHECK(term(budget, "arm").sigma == Approx(1e-6));
  CHECK_FALSE(term(budget, "stop").counts);
}

TEST_CASE("A drift counts when chance does not explain it, and so does the judge") {
  SampleRun run;
  run.moves.push_back(run.moves[0]);
  run.moves[0].judge_sigma = 3e-6;
  run.moves[1].judge_sigma = 5e-6;
  JudgedMove& pose = run.moves.emplace_back(run.moves[0]);
  pose.move = {"c01.P1", CertificatePart::kPose, "P1", "", 1, {0.3, 0.1}};
  pose.judge_sigma = 90e-6;  // which tells nothing of the targets
  CellAccuracy accuracy = cell_accuracy(run.moves);
  accuracy.drift = PoseDrift{10, 6e-6, 1e-6, {}, {}};
  UncertaintyBudget budget = run.budget(accuracy);
  CHECK(term(budget, "judge").sigma == Approx(std::sqrt(17.0) * 1e-6));
  CHECK(term(budget, "drift").sigma == Approx(9e-6 / std::sqrt(24.0)));
  accuracy.drift->shift_chance = 7e-6;
  CHECK(term(run.budget(accuracy), "drift").sigma == 0.0);
}

TEST_CASE("The words name the largest term and say whether the budget explains what was found") {
  SampleRun run;
  run.moves[0].stop_below = 100e-6;
  UncertaintyBudget budget = run.budget();
  CHECK(budget.largest().what == "stop rule");
  CHECK_THAT(budget_words(budget), Catch::Contains("Less was found than expected") &&
                                       Catch::Contains("gained at the stop rule") &&
                                       Catch::Contains("lower servo.tolerance_mm"));
  budget.found = 1e-3;
  CHECK_THAT(budget_words(budget), Catch::Contains("More was found than expected"));
  budget.found_95 = Interval{0.0, 2e-3};
  CHECK_THAT(budget_words(budget), Catch::Contains("explains what was found"));
}

}  // namespace
}  // namespace planar
