#include "planar_servo/offline/plan/experiment_plan.h"

#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "plan/training_order.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/record/recording_start.h"
#include "support/sample_cells.h"
#include "support/texts.h"

namespace planar {
namespace {

constexpr double kRounding = 1e-12;

TEST_CASE("The experiment records what the paper did, and every position can be reached") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const std::vector<PlanRow> plan = experiment_plan(cell, 1).rows;
  std::map<Purpose, int> counts;
  std::set<std::string> ids;
  for (const PlanRow& row : plan) {
    ++counts[row.plan];
    CHECK(ids.insert(row.id).second);
  }
  CHECK(counts[Purpose::kTrain] == 200);
  CHECK(counts[Purpose::kTest] == 30);
  CHECK(counts[Purpose::kCheck] == 3 * 24 + 3 * 4 * 25);
  CHECK(counts[Purpose::kLaidBoard] == 1);
  CHECK_NOTHROW(joints_of_plan(cell, plan));
}

TEST_CASE(
    "A short experiment keeps its readings, a few targets and as many test positions in all") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const ExperimentSize size = with_loop_only(with_readings({}, 12), 2);
  const ExperimentPlan plan = experiment_plan(cell, 1, size);
  std::map<Purpose, int> counts;
  for (const PlanRow& row : plan.rows) ++counts[row.plan];
  CHECK(counts[Purpose::kTrain] + counts[Purpose::kSweep1] + counts[Purpose::kSweep3] == 12);
  CHECK(counts[Purpose::kTest] == 8);
  CHECK(plan.circle_points.empty());
  CHECK(control_targets(cell.workspace, size).size() == 8);
}

TEST_CASE("Further lays of the board join the plan and move no other row") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  ExperimentSize size;
  size.lays = 4;
  const std::string one = plan_text(experiment_plan(cell, 1).rows);
  const std::string four = plan_text(experiment_plan(cell, 1, size).rows);
  const std::string first = "plane_grid_00,plane_grid,,,,,,\n";
  CHECK(four == test::replaced(one, first,
                               first + "plane_grid_01,plane_grid,,,,,,\n"
                                       "plane_grid_02,plane_grid,,,,,,\n"
                                       "plane_grid_03,plane_grid,,,,,,\n"));
}

TEST_CASE("The same seed draws the same training positions, another seed others") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const auto first_training_point = [&](std::uint64_t seed) {
    for (const PlanRow& row : experiment_plan(cell, seed).rows)
      if (row.plan == Purpose::kTrain) return std::get<TipPose>(row.where).p;
    throw std::logic_error("no training position");
  };
  CHECK(first_training_point(3) == first_training_point(3));
  CHECK(first_training_point(3) != first_training_point(4));
}

TEST_CASE("Training places that follow each other in time are no neighbours in space") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    CHECK(test::step_over_distance(experiment_plan(cell, seed).rows) > 0.85);
}

TEST_CASE("The control targets lie on the paper's four circles") {
  const Workspace workspace = read_cell(test::paper_cell_file()).workspace;
  const std::vector<ControlCircle> circles = control_circles(workspace);
  REQUIRE(circles.size() == 4);
  CHECK(control_targets(workspace).size() == 100);
  for (const ControlCircle& circle : circles)
    for (const TargetRow& target : circle.targets)
      CHECK((target.p_d - circle.center).norm() == Approx(0.2).margin(kRounding));
}

TEST_CASE("The paper's circles are those of the paper's workspace, and shrink with it") {
  const auto paper = circles_within({0.060, 0.540, {}});
  CHECK(paper.check_mm == ExperimentCircles().check_mm);
  CHECK(paper.run_mm == ExperimentCircles().run_mm);
  CHECK(paper.sweep_mm == 300);
  CHECK(paper.control_mm == 200);
  CHECK(paper.control_offset_mm == 200);
  const Workspace small{0.060, 0.240, {}};
  CHECK(circles_within(small).run_mm == std::array<int, 4>{75, 113, 150, 188});
  for (const TargetRow& target : control_targets(small)) CHECK(!small.violation(target.p_d));
}

TEST_CASE("A plan beyond reach is refused whole, every bad row by its id and with a remedy") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const std::vector<PlanRow> plan{{"far", Purpose::kTrain, TipPose{{0.7, 0.0}, 0.0}},
                                  {"fine", Purpose::kTrain, TipPose{{0.3, 0.0}, 0.0}},
                                  {"near", Purpose::kTrain, TipPose{{0.01, 0.0}, 0.0}}};
  std::vector<std::string> refused;
  try {
    joints_of_plan(cell, plan);
  } catch (const InputError& error) {
    for (const Refusal& refusal : error.refusals()) {
      CHECK(refusal.cause == Cause::kUnreachable);
      CHECK_FALSE(refusal.remedy.empty());
      refused.push_back(refusal.where);
    }
  }
  CHECK(refused == std::vector<std::string>{"plan row 'far'", "plan row 'near'"});
}

}  // namespace
}  // namespace planar
