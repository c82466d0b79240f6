#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/work/jog/jog_console.h"
#include "support/jog_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using test::JogBench;

constexpr double kOnePulse_m = 20e-6;  // of the paper's cell at full reach, all motors together

/// Targets that were taught before, or written by hand: the last two cannot be reached.
constexpr char kTable[] =
    "id,x_mm,y_mm,phi_deg\nnear,400,-280,-10\nfar,-400,100,\npoint 1,300,300,0\nout,900,0,0\n"
    "inside,20,0,0\n";

/// A console with the table above, its arm bent.
struct TaughtBench : JogBench {
  std::unique_ptr<JogConsole> taught;
  bool stop{false};

  explicit TaughtBench(const CellSettings& settings = read_cell(test::paper_cell_file()))
      : JogBench(settings) {
    folder.write("taught.csv", kTable);
    taught = std::make_unique<JogConsole>(read_calibrated_cell(cell), *devices,
                                          folder / "taught.csv", [this] { return stop; });
    CHECK(test::execute(*taught, "enable").done);
  }
  Joints joints() { return Transmission(cell.transmission).joints_from_pulses(pulses()); }
};

TEST_CASE("A taught place is gone to, farther than a jog goes, and by name") {
  TaughtBench bench;
  const PlanarArm arm(bench.cell.arm.geometry);
  for (const auto& [line, p] : {std::pair("go near", Eigen::Vector2d(0.4, -0.28)),
                                {"go far", {-0.4, 0.1}},
                                {"go  point 1", {0.3, 0.3}}}) {
    const auto answer = test::execute(*bench.taught, line);
    INFO(answer.text);
    REQUIRE(answer.done);
    CHECK_THAT(answer.text, Contains("by the links of the cell file: joints"));
    CHECK((arm.forward(bench.joints()).p - p).norm() < kOnePulse_m);
  }
}

TEST_CASE("With an arm that was found, a taught place is gone to by that arm") {
  const test::TemporaryFolder folder;
  FoundArm found;
  found.x.head<2>() << 0.303, 0.298;
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.arm_found = folder.write("arm.yaml", found_arm_text(found, {}, {}, "test"));
  TaughtBench bench(cell);
  const auto answer = test::execute(*bench.taught, "go near");
  REQUIRE(answer.done);
  CHECK_THAT(answer.text,
             Contains("moved to near, (400.000, -280.000) mm, by the arm that was found"));
  const Eigen::Vector2d reached = read_calibrated_cell(cell).planner.reached(bench.joints()).p;
  CHECK((reached - Eigen::Vector2d(0.4, -0.28)).norm() < kOnePulse_m);
}

TEST_CASE("An arm that the cell names and nobody has made leaves the links of the cell file") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.arm_found = "absent/arm.yaml";
  CHECK_THAT(test::execute(*TaughtBench(cell).taught, "go near").text, Contains("by the links"));
}

TEST_CASE(
    "A place that is not taught, not in reach or behind a border is refused, and nothing moves") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.workspace.keep_out.push_back({{0.0, -0.45}, 0.05});
  TaughtBench bench(cell);
  REQUIRE(test::execute(*bench.taught, "go near").done);
  const Pulses before = bench.pulses();
  const auto refused = [&](const std::string& line) {
    const auto answer = test::execute(*bench.taught, line);
    CHECK_FALSE(answer.done);
    CHECK(bench.pulses() == before);
    return answer.text;
  };
  CHECK(refused("go fra") == "no place 'fra' is taught; there are near, far, point 1, out, inside");
  CHECK_THAT(refused("go out"), Contains("out of reach"));
  CHECK_THAT(refused("go inside"), Contains("workspace reaches from"));
  CHECK_THAT(refused("go"), Contains("help says 'go ID"));
}

TEST_CASE("Before enabling and without a table a way is refused by what leads on") {
  JogBench bench;
  CHECK(bench.refused("go a") == "no place 'a' is taught; teach one first (command teach ID)");
  bench.done("teach a");
  CHECK_THAT(bench.refused("go a"), Contains("enable them first"));
  JogConsole without(read_calibrated_cell(bench.cell), *bench.devices, "");
  CHECK_THAT(test::execute(without, "go a").text, Contains("planar-jog takes one by --teach"));
}

TEST_CASE("The way to a taught place can be stopped, and is gone to its end by the next command") {
  TaughtBench bench;
  REQUIRE(test::execute(*bench.taught, "go near").done);
  bench.stop = true;
  const auto stopped = test::execute(*bench.taught, "go far");
  CHECK_FALSE(stopped.done);
  CHECK_THAT(stopped.text, Contains("stopped as asked; joints"));
  bench.stop = false;
  CHECK(test::execute(*bench.taught, "go far").done);
}

}  // namespace
}  // namespace planar
