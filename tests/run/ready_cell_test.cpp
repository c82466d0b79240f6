#include "planar_servo/work/run/ready_cell.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE("The calibration narrows the guard, but not that of a chain that has no guard") {
  ServoRequest request;
  const CellSettings cell = read_cell(test::workshop_cell_file());
  request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  const auto devices = open_cell(cell);
  const GuardLimits widest;
  const GuardLimits guarded = ReadyCell(request, *devices).limits();
  CHECK(guarded.noise_m == widest.noise_m);
  CHECK(guarded.distance_m < widest.distance_m);
  CHECK(std::isfinite(guarded.correction_m));
  request.policy.guards_looks = false;
  const GuardLimits unguarded = ReadyCell(request, *devices).limits();
  CHECK(std::isinf(unguarded.noise_m));
  CHECK(std::isinf(unguarded.correction_m));
  CHECK(unguarded.distance_m == widest.distance_m);
}

TEST_CASE(
    "A broken health file leaves the arm to be moved by hand, and no run or plan of a check") {
  const test::TemporaryFolder folder;
  CellSettings cell = read_cell(test::workshop_cell_file());
  cell.health = folder.write("health.yaml", "kind: [health\n");
  const CalibratedCell read = read_calibrated_cell(cell);
  CHECK(read.vision);
  const test::Refused broken(Cause::kInvalid, "health.yaml:2:1");
  CHECK_THROWS_MATCHES(require_calibrated(read), InputError, broken);
  CHECK_THROWS_MATCHES(foresee_check(read), InputError, broken);
}

TEST_CASE("A map whose fit speaks against it is refused until a person accepts it") {
  CalibratedCell cell = read_calibrated_cell(read_cell(test::workshop_cell_file()));
  CHECK_FALSE(accept_map(cell, false));
  cell.vision->map_objection = Refusal{"its fit says not to use it"};
  CHECK_THROWS_WITH(accept_map(cell, false),
                    Catch::Contains("map.yaml: its fit says not to use it") &&
                        Catch::Contains("--no-error-map") && Catch::Contains("--accept-map"));
  CHECK(accept_map(cell, true) == cell.vision->map_objection->fault);
}

}  // namespace
}  // namespace planar
