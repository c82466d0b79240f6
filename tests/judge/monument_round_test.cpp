#include "planar_servo/machine/judge/cell_judge.h"

#include <catch2/catch.hpp>
#include <deque>
#include <map>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using Ids = std::vector<std::string>;

/// An exact tracker that stands a metre beside the base, and somebody who places the reflector
/// beside a monument now and then.
class HandledTracker final : public Tracker {
 public:
  explicit HandledTracker(const CellSettings& cell) {
    for (const Monument& monument : cell.datum) places_[monument.id] = monument.p_B;
  }

  Ids asked;
  std::map<std::string, std::deque<Eigen::Vector3d>> misplaced;  ///< one after the other
  Eigen::Vector3d moved{0.0, 0.0, 0.0};                          ///< the tracker, since
  std::optional<bool> answer;                                    ///< to keeps()
  Ids doubted;

  TrackerAnswer measure_tool(const std::string& /*place*/) override { return {}; }
  TrackerAnswer measure_monument(const std::string& id) override {
    asked.push_back(id);
    Eigen::Vector3d p = places_.at(id) - Eigen::Vector3d(0.0, -1.0, 0.0) - moved;
    if (auto& wrong = misplaced[id]; !wrong.empty()) {
      p += wrong.front();
      wrong.pop_front();
    }
    return TrackerAnswer::of({0.0, p});
  }
  std::optional<bool> keeps(const std::string& id) override {
    doubted.push_back(id);
    return answer;
  }
  int readings_per_monument() const override { return 1; }

 private:
  std::map<std::string, Eigen::Vector3d> places_;
};

struct RoundBench {
  test::TemporaryFolder folder;
  CellSettings cell = read_cell(test::paper_cell_file());
  HandledTracker tracker{cell};
  GrowingFile table{folder / "tracker.csv", tracker_header()};
  ReflectorReadings readings{cell, tracker, table, {}};

  Ids ids() const {
    Ids ids;
    for (const TrackerRow& row : read_tracker(folder / "tracker.csv")) ids.push_back(row.id);
    return ids;
  }
};

const Ids kAll{"datum1", "datum2", "datum3"};
const Eigen::Vector3d kOff(0.5 * kMillimetre, 0.0, 0.0);

TEST_CASE(
    "A monument that contradicts the others is read again, and only that reading is written") {
  RoundBench bench;
  bench.tracker.misplaced["datum2"] = {kOff};
  bench.tracker.answer = false;
  const std::vector<MonumentSeen> seen = bench.readings.read_monuments();
  CHECK(bench.tracker.asked == Ids{"datum1", "datum2", "datum2", "datum3"});
  CHECK(bench.tracker.doubted == Ids{"datum2"});
  CHECK(bench.ids() == kAll);
  CHECK(MonumentRound(bench.cell, {}, seen).doubt().fault.empty());
}

TEST_CASE("A reading in contradiction is kept by whoever reads, or where nobody can be asked") {
  RoundBench bench;
  bench.tracker.misplaced["datum2"] = {kOff};
  if (GENERATE(true, false)) bench.tracker.answer = true;
  const std::vector<MonumentSeen> seen = bench.readings.read_monuments();
  // The third is not doubted for what was kept of the second.
  CHECK(bench.tracker.doubted == Ids{"datum2"});
  CHECK(bench.tracker.asked == kAll);
  CHECK(bench.ids() == kAll);
  CHECK(MonumentRound(bench.cell, {}, seen).doubt().cause == Cause::kContradiction);
}

TEST_CASE("Monuments read at one and the same place contradict each other") {
  RoundBench bench;
  const Eigen::Vector3d to_first = bench.cell.datum[0].p_B - bench.cell.datum[1].p_B;
  bench.tracker.misplaced["datum2"] = {to_first, to_first};
  bench.tracker.answer = false;
  bench.readings.read_monuments();
  CHECK(bench.tracker.doubted == Ids{"datum2", "datum2"});
}

TEST_CASE("At the end each monument is compared with itself at the beginning") {
  RoundBench bench;
  const std::vector<MonumentSeen> first = bench.readings.read_monuments();
  bench.readings.read_monuments({}, first);
  CHECK(bench.tracker.doubted.empty());
  bench.tracker.moved = kOff;
  bench.tracker.answer = true;
  const std::vector<MonumentSeen> last = bench.readings.read_monuments({}, first);
  CHECK(bench.tracker.doubted == Ids{"datum1"});
  CHECK_THAT(MonumentRound(bench.cell, first, last).doubt().fault, Contains("moved, by 0.500 mm"));
}

TEST_CASE("A round keeps to the cell file no more than the round before did") {
  RoundBench bench;
  bench.tracker.misplaced["datum2"] = {kOff, kOff};
  bench.tracker.answer = true;
  const std::vector<MonumentSeen> first = bench.readings.read_monuments();
  bench.tracker.doubted.clear();
  bench.readings.read_monuments({}, first);
  CHECK(bench.tracker.doubted.empty());
}

TEST_CASE("A monument's readings are described with their scatter and what they differ by") {
  RoundBench bench;
  const double sigma = 10e-6;
  MonumentRound round(bench.cell, {}, {{"datum1", {0.0, {1.0, 0.0, 0.0}}}});
  const std::string words = round.words(
      {{"datum2", {0.0, {1.0, 1.2728022, sigma}}}, {"datum2", {0.0, {1.0, 1.2728022, -sigma}}}});
  CHECK_THAT(words, Contains("monument 'datum2': 2 readings at (1000.000, 1272.802, 0.000) mm"));
  CHECK_THAT(words, Contains("scatter 0.008 mm per axis"));
  CHECK_THAT(words, Contains("distance to 'datum1' +0.010 mm against the cell file"));
  TrackerReading mean{0.0, {1.0, 1.2728022, 0.0}, 11, 7e-6};
  CHECK_THAT(round.words({{"datum2", mean}}),
             Contains("11 readings") && Contains("scatter 0.007 mm"));
  const MonumentRound again(bench.cell, {{"datum1", {0.0, {1.0, 2e-5, 0.0}}}}, {});
  CHECK_THAT(again.words({{"datum1", {0.0, {1.0, 0.0, 0.0}}}}),
             Contains("1 reading at") && Contains("0.020 mm from where it was at the beginning"));
}

}  // namespace
}  // namespace planar
