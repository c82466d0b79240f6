#include <catch2/catch.hpp>
#include <memory>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/work/run/servo_run.h"
#include "support/sample_cells.h"
#include "support/silent_cell.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE(
    "A run is judged by the cell's tracker where that is asked for, its monuments read once") {
  const test::TemporaryFolder folder;
  const CellSettings whole = read_cell(test::workshop_cell_file());
  test::SilentCell devices(whole);
  ServoRequest request;
  CellSettings cell = whole;
  cell.truth.reset();
  request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  request.folder.path = folder / "run";
  request.policy.checks_health = false;
  request.judge =
      std::make_shared<TrackerJudge>(cell, request.cell->vision->tool, devices.tracker(),
                                     request.folder.path / "judge.csv", std::function<bool()>());
  ServoRun run(request, devices);
  for (const char* id : {"a", "b"}) {
    const TargetResult& result = run.move_to({id, {0.2, 0.1}, std::nullopt});
    REQUIRE(result.not_judged.empty());
    CHECK(result.after_judged.value().norm() < 0.2e-3);
    CHECK(result.sigma_judged_m.value() >= whole.tracker.sigma_m);
  }
  std::size_t monuments = 0;
  for (const TrackerRow& row : read_tracker(request.folder.path / "judge.csv"))
    monuments += row.id == whole.datum.front().id ? 1 : 0;
  CHECK(monuments == kMonumentReadings);
}

}  // namespace
}  // namespace planar
