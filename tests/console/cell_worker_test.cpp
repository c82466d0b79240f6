#include "planar_servo/console/cell_worker.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <future>
#include <thread>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "support/eventually.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;
using test::replaced;

constexpr double kLongest_s = 20.0;

/// A worker at a cell whose joint 1 takes three seconds for the longest jog.
struct Bench {
  test::TemporaryFolder folder;
  KnownCell cell;
  StateBoard board;
  std::atomic<bool> interrupted{false};
  CellWorker worker;

  explicit Bench(const std::string& targets = "id,x_mm,y_mm,phi_deg\n")
      : cell(slow_cell(folder, targets)),
        worker(cell, board, [this] { return interrupted.load(); }) {}

  static std::filesystem::path slow_cell(const test::TemporaryFolder& folder,
                                         const std::string& targets) {
    const auto paper = test::paper_cell_file();
    folder.write("truth.yaml", read_file(paper.parent_path() / "truth.yaml"));
    folder.write("targets.csv", targets);
    return folder.write(
        "cell.yaml", replaced(read_file(paper), "max_speed_deg_s: 60, max_acceleration_deg_s2: 300",
                              "max_speed_deg_s: 5, max_acceleration_deg_s2: 300"));
  }

  double joint_1_deg() const { return board.state().arm->stand->theta[0] / kDegree; }
  std::string command(const std::string& line, StopsKnown known) {
    return worker.command(parse_arm_command(line).value(), line, known);
  }
  void hold(const std::string& line, StopsKnown known) {
    worker.hold(parse_arm_command(line).value(), line, known);
  }
  bool rests() { return worker.wait_for_rest(kLongest_s); }
  void begin_move() {
    command("enable", 0);
    worker.begin(Doing::kRunning, "a long job", 0,
                 [](CellDevices& devices, const auto& stop) -> CellWorker::Tell {
                   while (!stop()) devices.clock().sleep_for_s(0.005);
                   return {};
                 });
  }
};

TEST_CASE("A held jog ends on its way when nobody keeps it, and the arm knows where it is") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("enable", 0));
  bench.hold("joint 1 15", 0);
  REQUIRE(test::eventually([&] { return bench.worker.keep() && bench.joint_1_deg() > 0.1; }));
  REQUIRE(bench.rests());
  const double turned_deg = bench.joint_1_deg();
  CHECK(turned_deg > 0.1);
  CHECK(turned_deg < 7.5);
  REQUIRE_NOTHROW(bench.command("joint 1 -0.1", 0));
  CHECK(bench.joint_1_deg() == Approx(turned_deg - 0.1).margin(0.001));
}

TEST_CASE("A held jog that is kept goes to its end") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("enable", 0));
  bench.hold("joint 1 2", 0);
  while (bench.worker.keep()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(bench.joint_1_deg() == Approx(2.0).margin(0.001));
}

TEST_CASE("A command is stopped on its way, and says so") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("enable", 0));
  std::thread stops([&] {
    test::eventually([&] { return bench.joint_1_deg() > 0.2; });
    bench.worker.stop();
  });
  CHECK_THROWS_MATCHES(bench.command("joint 1 15", 0), WorkError,
                       Refused(Cause::kStopped, "end point"));
  stops.join();
  CHECK(bench.joint_1_deg() < 14.9);
}

TEST_CASE("While a job runs nothing else moves, and it is named") {
  Bench bench;
  bench.begin_move();
  CHECK_THROWS_MATCHES(bench.command("joint 1 1", 0), WorkError,
                       Refused(Cause::kBusy, "a long job"));
  CHECK_THROWS_MATCHES(bench.hold("x 1", 0), WorkError, Refused(Cause::kBusy, "a long job"));
  CHECK_FALSE(bench.worker.keep());
  CHECK(bench.worker.stop());
  REQUIRE(bench.rests());
  CHECK_FALSE(bench.worker.stop());
  CHECK_NOTHROW(bench.command("joint 1 0.1", 2));
}

TEST_CASE("Whoever hears that a job has ended may order at once") {
  Bench bench;
  for (int i = 0; i < 3; ++i) {
    std::promise<void> ended;
    bench.worker.begin(Doing::kChecking, "a short job", 0,
                       [&](auto&, const auto&) { return [&] { ended.set_value(); }; });
    ended.get_future().wait();
    CHECK_NOTHROW(bench.command("enable", 0));
  }
}

TEST_CASE("What was ordered before a stop begins no more, however late it comes") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("enable", 0));
  const double begun_deg = bench.joint_1_deg();
  const StopsKnown unsaid = bench.worker.stops_known({});
  bench.worker.stop();
  CHECK_THROWS_MATCHES(bench.command("joint 1 1", unsaid), WorkError, Refused(Cause::kStopped));
  CHECK_THROWS_MATCHES(bench.hold("joint 1 1", 0), WorkError, Refused(Cause::kStopped));
  CHECK_THROWS_MATCHES(bench.command("joint 1 1", bench.worker.stops_known({})), WorkError,
                       Refused(Cause::kStopped));
  CHECK(bench.joint_1_deg() == begun_deg);
  CHECK_NOTHROW(bench.command("joint 1 1", bench.worker.stops_known(bench.board.state().stops)));
}

TEST_CASE("Who takes a cell over may move it at once, and who had it no more") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("enable", 0));
  bench.worker.hand_over();
  CHECK_THROWS_MATCHES(bench.command("joint 1 1", 0), WorkError, Refused(Cause::kStopped));
  CHECK_NOTHROW(bench.command("joint 1 1", bench.worker.stops_known({})));
}

TEST_CASE("Nothing begins while the cell is about to be opened anew") {
  Bench bench;
  REQUIRE_NOTHROW(bench.command("where", 0));
  bench.worker.close();
  CHECK_THROWS_MATCHES(bench.command("where", 0), WorkError,
                       Refused(Cause::kBusy, "the cell's files"));
}

TEST_CASE("An interrupt ends what runs") {
  Bench bench;
  bench.begin_move();
  bench.interrupted = true;
  CHECK(bench.rests());
}

TEST_CASE("Only motions are held") {
  Bench bench;
  for (const char* line : {"home", "enable", "go a", "look"}) {
    INFO(line);
    CHECK_THROWS_AS(bench.hold(line, 0), InputError);
  }
}

TEST_CASE("A table that nobody can teach to is a doubt, and the cell moves all the same") {
  Bench bench("id,x_mm,y_mm,z_mm\nA,1,2,3\n");
  const auto doubts = bench.board.state().doubts;
  REQUIRE(doubts.size() == 1);
  CHECK_THAT(doubts[0].fault, Catch::Contains("no place can be taught"));
  REQUIRE_NOTHROW(bench.command("enable", 0));
  CHECK_THROWS_MATCHES(bench.command("teach B", 0), InputError, Refused(Cause::kMissing, "table"));
  CHECK_NOTHROW(bench.command("joint 1 0.1", 0));
}

TEST_CASE("A picture is there for whoever watches, with the lamps in it") {
  Bench bench;
  bench.worker.watch();
  CHECK(test::eventually([&] { return bench.board.state().lamps.has_value(); }));
  CHECK(bench.worker.pictures().whole().bytes);
  CHECK(bench.worker.pictures().lamp(1).bytes);
}

}  // namespace
}  // namespace planar
