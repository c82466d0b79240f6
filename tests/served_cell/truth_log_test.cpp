#include "planar_servo/served_cell/truth_log.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/units.h"
#include "planar_servo/io/csv/csv_table.h"
#include "support/eventually.h"
#include "support/temporary_folder.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

struct TrueRow {
  double t_s, x_mm, y_mm, phi_deg;
};

std::vector<TrueRow> rows_of(const std::filesystem::path& file) {
  CsvFile table(file, "truth-log", {"t_s", "x_mm", "y_mm", "phi_deg"});
  std::vector<TrueRow> rows;
  while (table.next_row())
    rows.push_back(
        {table.number("t_s"), table.number("x_mm"), table.number("y_mm"), table.number("phi_deg")});
  return rows;
}

TEST_CASE("The truth's log has a row whenever the tool has moved, and none while it rests") {
  const test::TemporaryFolder folder;
  const VirtualHardware hardware = test::sample_hardware();
  LiveCell live(draw_truth(3), hardware);
  const std::filesystem::path file = folder / "truth.csv";
  const TruthLog log(file, live);
  const auto n_rows = [&] { return rows_of(file).size(); };
  REQUIRE(test::eventually([&] { return n_rows() == 1; }));
  SteadyClock clock;
  clock.sleep_for_s(0.2);
  CHECK(n_rows() == 1);
  const double moved_s = clock.now_s();
  live.now([&](VirtualCell& cell) { cell.turn_motor(0, hardware.home_pulses()[0] + 50000); });
  REQUIRE(test::eventually([&] { return n_rows() == 2; }));
  const TrueRow row = rows_of(file).back();
  const TipPose tip = live.true_tip();
  CHECK(row.t_s >= moved_s);
  CHECK(row.x_mm == Approx(tip.p.x() / kMillimetre).margin(1e-6));
  CHECK(row.y_mm == Approx(tip.p.y() / kMillimetre).margin(1e-6));
  CHECK(row.phi_deg == Approx(tip.phi / kDegree).margin(1e-6));
  log.require_well();
}

}  // namespace
}  // namespace planar
