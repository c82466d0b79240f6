#include "planar_servo/experiment/experiment.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/core/units.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

/// A fifth of the paper's places.
constexpr ExperimentSize kSmall{8, 12, 60, 10, 8, 6, 3};

/// A map of 60 places serves less well than one of 200: these bounds tell a chain that works from
/// one that does not, no more.
constexpr double kOursBelow_m = 0.015e-3, kPaperBelow_m = 0.5e-3, kBeforeAbove_m = 1e-3;

ExperimentReport run_small_experiment(const std::filesystem::path& folder) {
  const CellSettings cell = read_cell(test::paper_cell_file());
  ExperimentRequest request{cell, parse_board("circles:11x11:50mm"), 1, folder / "run"};
  request.size = kSmall;
  const auto devices = open_cell(cell);
  return run_experiment(request, *devices);
}

void check_rows(const std::vector<ComparisonRow>& rows, std::size_t count, double low,
                double high) {
  REQUIRE(rows.size() == count);
  for (const ComparisonRow& row : rows) {
    INFO(row.label);
    CHECK((row.ours > low && row.ours < high));
    CHECK((row.paper_chain > low && row.paper_chain < high));
  }
}

void check_rows(const std::vector<AccuracyRow>& rows, std::size_t count, double low, double high) {
  std::vector<ComparisonRow> a1, a2;
  for (const AccuracyRow& row : rows) {
    a1.push_back({row.label, row.ours.a1, row.paper_chain.a1, row.paper});
    a2.push_back({row.label, row.ours.a2, row.paper_chain.a2, row.paper});
    CHECK(row.ours.a1 <= row.ours.a2);  // A2 does not see what points the wrong way
    CHECK(row.paper_chain.a1 <= row.paper_chain.a2);
  }
  check_rows(a1, count, low - 0.4, high);
  check_rows(a2, count, low, high);
}

TEST_CASE("A small experiment fills every table of the paper, and our chain beats the paper's") {
  const test::TemporaryFolder folder;
  const ExperimentReport report = run_small_experiment(folder.path());
  const PaperTables& tables = report.tables;
  check_rows(tables.run_correlation, ExperimentCircles().run_mm.size(), 0.95, 1.0 + 1e-9);
  check_rows(tables.idw_accuracy, ExperimentCircles().check_mm.size(), -1.0, 1.0);
  check_rows(tables.repeatability, ExperimentCircles().check_mm.size(), 0.0, 1e-6);
  check_rows(tables.rbf_accuracy, ExperimentCircles().check_mm.size(), 0.8, 1.0);
  check_rows(tables.mean_accuracy, 2, 0.0, 1.0);
  REQUIRE(tables.positioning.size() == report.circles.size() + 1);
  for (const PositioningRow& row : tables.positioning) {
    INFO(row.label);
    CHECK((row.ours > 0.0 && row.ours < row.paper_chain && row.paper_chain < kPaperBelow_m));
    CHECK(row.paper_before ==
          Approx(row.paper_after / (1.0 - row.paper_improvement)).epsilon(0.01));
  }
  REQUIRE(tables.map_sources.size() == 6);
  CHECK(tables.map_sources[0].ours > 0.9 * kSmall.training_points);
  CHECK(tables.map_sources[0].ours <= kSmall.training_points);
  CHECK(tables.map_sources[1].ours == kSmall.test_points);
  CHECK(tables.map_sources[3].ours < 0.5 * tables.map_sources[2].ours);
  CHECK(tables.map_sources[4].paper_chain == tables.map_sources[0].paper_chain);  // a centre each
  CHECK((tables.map_sources[5].paper_chain > 20.0 && tables.map_sources[5].paper_chain < 320.0));
  CHECK(tables.mean_accuracy[1].ours.a2 ==
        Approx((tables.rbf_accuracy[0].ours.a2 + tables.rbf_accuracy[1].ours.a2 +
                tables.rbf_accuracy[2].ours.a2) /
               3.0));

  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  CHECK(ours.targets == 4 * static_cast<std::size_t>(kSmall.control_points));
  CHECK(ours.reached == ours.targets);
  CHECK(paper.before_truth->mean > kBeforeAbove_m);
  CHECK(ours.before_truth->mean < 0.1 * paper.before_truth->mean);  // by the arm that was found
  CHECK(ours.after_truth->mean < kOursBelow_m);
  CHECK(ours.after_truth->mean < paper.after_truth->mean);
  CHECK(report.prediction.mean > 0.5 * ours.after_truth->mean);
  CHECK(report.prediction.mean < 2.0 * ours.after_truth->mean);

  const nlohmann::json json = experiment_json(report);
  for (int table = 1; table <= 7; ++table) CHECK(!json["table" + std::to_string(table)].empty());
  CHECK(json["table7"][0]["ours"].get<double>() ==
        Approx(tables.positioning[0].ours / kMillimetre));
  CHECK(json["table7"].size() == report.circles.size());
  CHECK(json["table7"][0]["ours_improvement"].get<double>() ==
        Approx(1.0 - tables.positioning[0].ours / tables.positioning[0].before));
  CHECK(json["table5"][0]["paper_chain_a1"].get<double>() == tables.rbf_accuracy[0].paper_chain.a1);
}

TEST_CASE("Without a tracker reading a laid board and poses place the tool, but for the turn") {
  const test::TemporaryFolder folder;
  const CellSettings cell = read_cell(test::paper_cell_file());
  ExperimentRequest request{cell, parse_board("circles:11x11:50mm"), 1, folder / "run"};
  request.size = kSmall;
  request.size.unattended_poses = 150;
  request.size.lays = 8;
  request.uses_tracker = false;
  request.dots_height = -5.5 * kMillimetre;
  const auto devices = open_cell(cell);
  const ExperimentReport report = run_experiment(request, *devices);
  const ServoFigures ours = figures_of(report.ours);
  CHECK(ours.reached == control_targets(cell.workspace, kSmall).size());
  CHECK(ours.after_truth->mean < 0.03 * kMillimetre);
  REQUIRE(report.turn_taken_out);
  CHECK(std::abs(*report.turn_taken_out) > 0.1 * kDegree);  // joint 1's zero is off by 0.2
  CHECK(experiment_json(report)["table1"].empty());
  CHECK_THAT(experiment_text(report), Catch::Contains("no tracker reading fixed the turn"));
}

}  // namespace
}  // namespace planar
