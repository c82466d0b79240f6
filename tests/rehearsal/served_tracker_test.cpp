#include "planar_servo/machine/rehearsal/served_cell.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "support/eventually.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kStart_s = 1000.0;
const TrackerReading kReading{5.0, {1.25, -0.0317, 0.2}};

/// Reads a line as a client would that was told how the tracker writes.
StreamedReading as_read(const ReflectorDialect& dialect, double now_s) {
  ReflectorLines lines(dialect, kStart_s, 1);
  TrackerDialect told;
  told.csv.decimal_comma = dialect.decimal_comma;
  if (dialect.decimal_comma) told.csv.separator = ';';
  told.csv.renamed_columns["t_s"] = "t_s";
  TrackerLines reader("lines", told);
  REQUIRE_FALSE(reader.next(lines.header()));
  return reader.next(lines.next(now_s, kReading).value()).value();
}

TEST_CASE("A served tracker's line is read as the reading it was made from") {
  for (const bool decimal_comma : {false, true}) {
    INFO(decimal_comma);
    ReflectorDialect dialect;
    dialect.decimal_comma = decimal_comma;
    const StreamedReading read = as_read(dialect, kStart_s + 1234.5);
    CHECK((read.p_L - kReading.p_L).norm() < 0.1 * kMicrometre);
    CHECK(read.t_s.value() == Approx(kStart_s + 1234.5).margin(1e-4));
  }
}

TEST_CASE("A served tracker's clock has its offset at first and runs fast by its rate") {
  const ReflectorDialect dialect{37.0, 50.0};
  CHECK(as_read(dialect, kStart_s).t_s.value() == Approx(kStart_s + 37.0).margin(1e-4));
  CHECK(as_read(dialect, kStart_s + 2000.0).t_s.value() == Approx(kStart_s + 2037.1).margin(1e-4));
}

TEST_CASE("A served tracker's beam is broken for the stated share of the time, six seconds each") {
  ReflectorDialect dialect;
  dialect.broken_percent = 3.0;
  ReflectorLines lines(dialect, kStart_s, 1);
  constexpr int kReadings = 2'000'000, kBreak = 120;
  int silent = 0, run = 0, breaks = 0;
  for (int i = 0; i < kReadings; ++i) {
    if (!lines.next(kStart_s, kReading)) {
      ++silent;
      ++run;
      continue;
    }
    CHECK(run % kBreak == 0);
    if (run > 0) ++breaks;
    run = 0;
  }
  // Breaks are counts of a Poisson process: about 500, so that the share scatters by 4.5 %.
  CHECK(silent / double{kReadings} == Approx(0.03).epsilon(0.2));
  CHECK(breaks > 300);
}

TEST_CASE("Options of a served tracker that cannot be meant are refused") {
  for (const ReflectorDialect& dialect :
       {ReflectorDialect{0.0, 2e4}, ReflectorDialect{1e12, 0.0},
        ReflectorDialect{0.0, 0.0, false, -1.0}, ReflectorDialect{0.0, 0.0, false, 100.0},
        ReflectorDialect{std::nan(""), 0.0}})
    CHECK_THROWS_AS(ReflectorLines(dialect, kStart_s, 1), InputError);
}

TEST_CASE("A served tracker follows the reflector to a monument and back to the tool") {
  const VirtualHardware hardware = test::sample_hardware();
  const Truth truth = draw_truth(3);
  LiveCell live(truth, hardware);
  const auto& [id, p_B] = hardware.monuments_B.front();
  const Eigen::Vector3d p_L = truth.tracker.X_LB * p_B;
  const auto distance = [&] { return (live.read_reflector().p_L - p_L).norm(); };
  CHECK(distance() > 0.05);
  CHECK(live.place_reflector(id));
  CHECK(distance() < 0.1 * kMillimetre);
  CHECK_FALSE(live.place_reflector("nowhere"));
  CHECK(distance() < 0.1 * kMillimetre);
  CHECK(live.place_reflector("tool"));
  CHECK(distance() > 0.05);
}

TEST_CASE("A served tracker goes on in its own file, and touches no other") {
  const test::TemporaryFolder folder;
  LiveCell live(draw_truth(3), test::sample_hardware());
  const auto lines = [&] {
    const std::string text = read_file(folder / "tracker.txt");
    return std::count(text.begin(), text.end(), '\n');
  };
  for (const int least : {3, 6}) {
    const ServedTracker tracker(folder / "tracker.txt", {}, 1, live);
    CHECK(test::eventually([&] { return lines() >= least; }));
  }
  CHECK_THROWS_MATCHES(ServedTracker(folder / "tracker.txt", {0.0, 0.0, true}, 1, live), InputError,
                       test::Refused(Cause::kForeign, "tracker.txt"));
}

}  // namespace
}  // namespace planar
