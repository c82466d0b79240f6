#include "planar_servo/offline/plan/proposed_plan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "field/bent_cell.h"
#include "plan/training_order.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/plan/experiment_plan.h"
#include "planar_servo/work/record/recording_start.h"
#include "support/refused.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

using test::Refused;

long rows_of(const ProposedPlan& plan, Purpose kind) {
  return std::count_if(plan.rows.begin(), plan.rows.end(),
                       [&](const PlanRow& row) { return row.plan == kind; });
}

TEST_CASE("A first plan has views, sweeps and places, and the arm can make all of it") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const ProposedPlan plan = propose_plan(cell, {40});
  CHECK(rows_of(plan, Purpose::kHeldBoard) >= 10);
  CHECK(rows_of(plan, Purpose::kLaidBoard) == 1);
  CHECK(rows_of(plan, Purpose::kSweep1) + rows_of(plan, Purpose::kSweep3) +
            rows_of(plan, Purpose::kTrain) ==
        40);
  CHECK_NOTHROW(joints_of_plan(cell, plan.rows));
  CHECK(plan.after < 0.2 * plan.before);
  CHECK(plan.worth_reading());
  CHECK(plan.enough <= rows_of(plan, Purpose::kTrain));
}

TEST_CASE(
    "A first plan keeps to the workspace, the limits and what is kept free, and says the rest") {
  CellSettings cell = read_cell(test::paper_cell_file());
  SECTION("The workspace ends before an elbow at a right angle") {
    cell.workspace.radius_max_m = 0.4;
    CHECK(propose_plan(cell, {40}).left_out == 0);
  }
  SECTION("Joint 1 does not turn all the way") {
    cell.transmission.limits_rad[0] = {-150.0 * kDegree, 150.0 * kDegree};
    const ProposedPlan plan = propose_plan(cell, {40});
    CHECK(rows_of(plan, Purpose::kSweep1) == 4);
    CHECK(plan.left_out == 1);
    CHECK_THAT(proposal_list(plan).text(), Catch::Contains("1 of the places"));
  }
  SECTION("Where joint 3 would turn nothing may be") {
    cell.workspace.keep_out = {{Eigen::Vector2d(0.0, 0.3), 0.06}};
    CHECK(rows_of(propose_plan(cell, {40}), Purpose::kSweep3) == 5);
  }
  const ProposedPlan plan = propose_plan(cell, {40, 20});
  CHECK_NOTHROW(joints_of_plan(cell, plan.rows));
  CHECK(rows_of(plan, Purpose::kSweep1) >= 4);
}

TEST_CASE("A first plan begins with what needs the tracker and ends with the views of the board") {
  const ProposedPlan plan = propose_plan(read_cell(test::paper_cell_file()), {40});
  const auto board = [](const PlanRow& row) { return shows_board(row.plan); };
  CHECK(needs_reading(plan.rows.front().plan));
  CHECK(std::is_partitioned(plan.rows.rbegin(), plan.rows.rend(), board));
}

TEST_CASE("The order of a plan's places is random in space, and the same every time") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const ProposedPlan plan = propose_plan(cell, {100});
  CHECK(rows_of(plan, Purpose::kTrain) == 76);
  CHECK(test::step_over_distance(plan.rows) > 0.85);
  CHECK(plan_text(plan.rows) == plan_text(propose_plan(cell, {100}).rows));
}

TEST_CASE("More readings promise more, until they are not worth their time") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  CHECK(propose_plan(cell, {100}).after < propose_plan(cell, {20}).after);
  ProposedPlan plan;
  plan.readings = 40;
  plan.before = 1.0e-3;
  plan.after = 0.98e-3;
  CHECK_FALSE(plan.worth_reading());
  CHECK_THAT(proposal_list(plan).text(), Catch::Contains("stop"));
}

TEST_CASE("Too few readings for a first plan are refused") {
  CHECK_THROWS_MATCHES(propose_plan(read_cell(test::paper_cell_file()), {11}), InputError,
                       Refused(Cause::kInsufficient, "11 tracker readings"));
}

TEST_CASE("A plan without a tracker has turned poses and lays, and the arm can make all of it") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const ProposedPlan plan = propose_plan(cell, {0, 60, 5});
  CHECK(rows_of(plan, Purpose::kHeldBoard) >= 10);
  CHECK(rows_of(plan, Purpose::kLaidBoard) == 5);
  CHECK(rows_of(plan, Purpose::kPose) > 50);
  CHECK(std::none_of(plan.rows.begin(), plan.rows.end(),
                     [](const PlanRow& row) { return needs_reading(row.plan); }));
  CHECK_NOTHROW(joints_of_plan(cell, plan.rows));
  CHECK_THAT(proposal_list(plan).text(), !Catch::Contains("readings"));
}

TEST_CASE("Unattended poses follow the readings") {
  const ProposedPlan plan = propose_plan(read_cell(test::paper_cell_file()), {40, 30});
  const auto attended = [](const PlanRow& row) { return needs_reading(row.plan); };
  CHECK(std::is_partitioned(plan.rows.begin(), plan.rows.end(), attended));
  CHECK(rows_of(plan, Purpose::kPose) > 25);
}

TEST_CASE("A plan that continues has poses of its own, and no number of a place before") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const std::vector<PairRow> pairs(1, [] {
    PairRow pair;
    pair.id = "pose_970";
    return pair;
  }());
  const ProposedPlan first = propose_plan(cell, {0, 60, 12}),
                     next = propose_plan(cell, {0, 30}, pairs);
  const auto place = [](const PlanRow& row) { return std::get<TipPose>(row.where).p; };
  for (const PlanRow& row : next.rows) {
    CHECK(std::stoi(row.id.substr(5)) > 970);
    for (const PlanRow& other : first.rows)
      if (other.plan == Purpose::kPose) CHECK((place(row) - place(other)).norm() > 1e-6);
  }
}

TEST_CASE("A plan that continues takes readings to scatter as those before did") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.arm.geometry.positive_rotation = Rotation::kCounterclockwise;
  std::mt19937 random(64);
  std::vector<PairRow> pairs;
  for (const PoseSample& sample : test::BentCell().samples(24, 0, random)) {
    PairRow& pair = pairs.emplace_back();
    pair.id = sample.id;
    pair.theta = Transmission(cell.transmission).joints_from_motors(sample.motors);
    pair.lamps_B = sample.lamps_B;
    pair.p_tracker = pair.p_reflector = sample.reflector_B;
    pair.sigma_vision = sample.sigma_lamp;
    pair.sigma_tracker = sample.sigma_reflector;
  }
  const auto expected_beside = [&](double sigma_at_tracker) {
    cell.tracker.sigma_m = sigma_at_tracker;
    return propose_plan(cell, {12}, pairs).after;
  };
  const double far = expected_beside(1e-7);
  CHECK(far == Approx(expected_beside(*pairs[0].sigma_tracker)).epsilon(0.01));
}

TEST_CASE("Without a tracker too few lays or poses are refused") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  for (const PlanRequest& request : {PlanRequest{0, 60, 1}, PlanRequest{0, 11, 5}})
    CHECK_THROWS_MATCHES(propose_plan(cell, request), InputError,
                         Refused(Cause::kInsufficient, "2 lays and 12 poses"));
}

TEST_CASE("A plan of nothing, and one whose poses the arm cannot reach, are refused") {
  CellSettings cell = read_cell(test::paper_cell_file());
  PairRow known;
  known.id = "p1";
  CHECK_THROWS_MATCHES(propose_plan(cell, {0, 0}, {known}), InputError,
                       Refused(Cause::kUnreachable, "1 are needed"));
  CHECK_NOTHROW(propose_plan(cell, {0, 3}, {known}));
  cell.workspace.keep_out = {{Eigen::Vector2d(0.0, 0.0), cell.workspace.radius_max_m}};
  CHECK_THROWS_MATCHES(propose_plan(cell, {0, 60, 5}), InputError,
                       Refused(Cause::kUnreachable, "12 are needed"));
}

TEST_CASE("An experiment of N readings takes N, sweeps included") {
  for (const int readings : {12, 40, 200, 1000}) {
    const ExperimentSize size = with_readings({}, readings);
    CHECK(2 * size.sweep_points + size.training_points == readings);
    CHECK(size.sweep_points >= 4);
    CHECK(size.sweep_points <= 24);
  }
}

}  // namespace
}  // namespace planar
