#include "planar_servo/console/arm_jobs.h"

#include <catch2/catch.hpp>
#include <thread>

#include "planar_servo/base/io/atomic_file.h"
#include "support/eventually.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::eventually;
using test::Refused;

constexpr char kPlan[] = "id,plan,x_mm,y_mm\nt1,train,300,-250\n";

/// A cell whose tracker is read by a person, with a plan of one place.
struct AskedCell {
  test::TemporaryFolder folder;
  KnownCell cell;
  StateBoard board;
  CellWorker worker;
  CellJobs jobs;
  PageSeat seat;
  RecordingJob recording;

  AskedCell()
      : cell(written(folder)),
        worker(cell, board, [] { return false; }),
        jobs(cell, board, worker),
        recording(cell, board, jobs, seat) {
    worker.command(EnableCommand{}, "enable", 0);
  }

  static std::filesystem::path written(const test::TemporaryFolder& folder) {
    const auto paper = test::paper_cell_file();
    folder.write("truth.yaml", read_file(paper.parent_path() / "truth.yaml"));
    folder.write("plan.csv", kPlan);
    return folder.write("cell.yaml", test::replaced(read_file(paper), "tracker: {sigma_mm",
                                                    "tracker: {source: ask, sigma_mm"));
  }

  int question() { return board.state().question.value_or(PageQuestion{}).id; }
  /// Waits for a question after this one and returns it.
  PageQuestion question_after(int id) {
    REQUIRE(eventually([&] { return question() > id; }));
    return board.state().question.value();
  }
};

TEST_CASE("A recording asks the page for the reflector until all is read") {
  AskedCell bench;
  CHECK(bench.recording.begin({"plan.csv", "recording"}, 0) == 1);
  const PageQuestion first = bench.question_after(0);
  CHECK_THAT(first.text, Contains("reflector on 'datum1'"));
  CHECK_THROWS_MATCHES(bench.seat.answer(first.id + 1, "1,2,3"), WorkError,
                       Refused(Cause::kBusy, "question " + std::to_string(first.id + 1)));
  CHECK(bench.question() == first.id);
  bench.seat.answer(first.id, " 1,2,3 ");
  CHECK_THAT(bench.question_after(first.id).text, Contains("reflector on 'datum2'"));
  bench.board.change([](CellState& state) { state.advice = "the board is gone"; });
  bench.worker.stop();
  REQUIRE(bench.worker.wait_for_rest(20.0));
  const CellState state = bench.board.state();
  CHECK_FALSE(state.question);
  CHECK(state.advice.empty());
  CHECK_THAT(state.job->ended, Contains("stopped as asked"));
  CHECK_THROWS_MATCHES(bench.seat.answer(1, "s"), WorkError, Refused(Cause::kBusy, "question 1"));
  CHECK_THROWS_MATCHES(bench.seat.confirm(), WorkError, Refused(Cause::kBusy));
}

TEST_CASE("A recording that cannot begin is refused before anything moves") {
  AskedCell bench;
  for (const char* name : {"", ".plan.csv", "../plan.csv", "no/plan.csv"}) {
    INFO(name);
    CHECK_THROWS_MATCHES(bench.recording.begin({name, "recording"}, 0), InputError,
                         Refused(Cause::kInvalid, "plan: "));
    CHECK_THROWS_MATCHES(bench.recording.begin({"plan.csv", name}, 0), InputError,
                         Refused(Cause::kInvalid, "out: "));
  }
  CHECK_THROWS_AS(bench.recording.begin({"none.csv", "recording"}, 0), InputError);
  CHECK_THROWS_AS(bench.recording.begin({"plan.csv", "recording", "", "often"}, 0), InputError);
  bench.folder.write("far.csv", "id,plan,x_mm,y_mm\nt1,train,900,0\n");
  CHECK_THROWS_MATCHES(bench.recording.begin({"far.csv", "recording"}, 0), InputError,
                       Refused(Cause::kUnreachable, "t1"));
  CHECK_FALSE(bench.board.state().job);
  CHECK_FALSE(std::filesystem::exists(bench.folder / "recording"));
}

TEST_CASE("What is wanted stands above what is seen, until the person leaves") {
  StateBoard board;
  {
    PageOperator person(
        board, [] { return false; }, [] {});
    person.say("g1: hold it");
    person.say("g1: tilt it");
    person.show("no board in the picture");
    CHECK(board.state().advice == "g1: tilt it\nno board in the picture");
    person.show("taken");
    CHECK(board.state().advice == "g1: tilt it\ntaken");
  }
  CHECK(board.state().advice.empty());
}

TEST_CASE("What is advised is confirmed once") {
  StateBoard board;
  PageOperator person(
      board, [] { return false; }, [] {});
  person.show("show the board");
  CHECK(board.state().advice == "show the board");
  CHECK_FALSE(person.entered());
  person.confirm();
  CHECK(person.entered());
  CHECK_FALSE(person.entered());
}

}  // namespace
}  // namespace planar
