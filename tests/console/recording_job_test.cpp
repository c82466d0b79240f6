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
  ConsoleJobs jobs{cell, board, worker, [] {}};

  AskedCell() : cell(written(folder)), worker(cell, board, [] { return false; }) {
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
  CHECK(begin_recording(bench.jobs, {"plan.csv", "recording"}, 0) == 1);
  const PageQuestion first = bench.question_after(0);
  CHECK_THAT(first.text, Contains("reflector on 'datum1'"));
  CHECK_THROWS_MATCHES(bench.jobs.person.answer(first.id + 1, "1,2,3"), WorkError,
                       Refused(Cause::kBusy, "question " + std::to_string(first.id + 1)));
  CHECK(bench.question() == first.id);
  bench.jobs.person.answer(first.id, " 1,2,3 ");
  CHECK_THAT(bench.question_after(first.id).text, Contains("reflector on 'datum2'"));
  bench.board.change([](CellState& state) { state.advice = "the board is gone"; });
  bench.worker.stop();
  REQUIRE(bench.worker.wait_for_rest(20.0));
  const CellState state = bench.board.state();
  CHECK_FALSE(state.question);
  CHECK(state.advice.empty());
  CHECK_THAT(state.job->ended, Contains("stopped as asked"));
  CHECK_THROWS_MATCHES(bench.jobs.person.answer(1, "s"), WorkError,
                       Refused(Cause::kBusy, "question 1"));
  CHECK_THROWS_MATCHES(bench.jobs.person.confirm(""), WorkError, Refused(Cause::kBusy));
}

TEST_CASE("A recording that cannot begin is refused before anything moves") {
  AskedCell bench;
  for (const char* name : {"", ".plan.csv", "../plan.csv", "no/plan.csv"}) {
    INFO(name);
    CHECK_THROWS_MATCHES(begin_recording(bench.jobs, {name, "recording"}, 0), InputError,
                         Refused(Cause::kInvalid, "plan: "));
    CHECK_THROWS_MATCHES(begin_recording(bench.jobs, {"plan.csv", name}, 0), InputError,
                         Refused(Cause::kInvalid, "out: "));
  }
  CHECK_THROWS_AS(begin_recording(bench.jobs, {"none.csv", "recording"}, 0), InputError);
  CHECK_THROWS_AS(begin_recording(bench.jobs, {"plan.csv", "recording", "", "often"}, 0),
                  InputError);
  bench.folder.write("far.csv", "id,plan,x_mm,y_mm\nt1,train,900,0\n");
  CHECK_THROWS_MATCHES(begin_recording(bench.jobs, {"far.csv", "recording"}, 0), InputError,
                       Refused(Cause::kUnreachable, "t1"));
  CHECK_FALSE(bench.board.state().job);
  CHECK_FALSE(std::filesystem::exists(bench.folder / "recording"));
}

TEST_CASE("A job that finds drives without their position says how they are homed at the page") {
  AskedCell bench;
  const ServoRequest request = bench.jobs.places.request([] { return false; });
  for (const auto& [way, remedy] : {std::pair(Homing::kSearch, "home the arm"),
                                    std::pair(Homing::kMark, "turn them to their marks")})
    CHECK_THROWS_MATCHES(request.may_home(way, "drives that have lost their position: 2"),
                         DriveError, Refused(Cause::kDevice, remedy));
}

TEST_CASE("What is wanted stands above what is seen, until the person leaves") {
  StateBoard board;
  {
    PageOperator page(board);
    const auto person = page.attend([] { return false; }, [] {});
    person->say("g1: hold it");
    person->say("g1: tilt it");
    person->show("no board in the picture");
    CHECK(board.state().advice == "g1: tilt it\nno board in the picture");
    person->show("taken");
    CHECK(board.state().advice == "g1: tilt it\ntaken");
  }
  CHECK(board.state().advice.empty());
}

TEST_CASE("What is advised is confirmed once") {
  StateBoard board;
  PageOperator page(board);
  const auto person = page.attend([] { return false; }, [] {});
  person->show("show the board");
  CHECK(board.state().advice == "show the board");
  CHECK_FALSE(person->entered());
  page.confirm("");
  CHECK(person->entered());
  CHECK_FALSE(person->entered());
}

TEST_CASE("What was advised before does not confirm what is advised now") {
  StateBoard board;
  PageOperator page(board);
  const auto person = page.attend([] { return false; }, [] {});
  person->say("g1: hold it still");
  person->show("no board in the picture");
  const std::string read = board.state().advice;
  person->show("taken in a second");
  page.confirm(read);
  person->say("the arm will move: take your hands away");
  CHECK_FALSE(person->entered());
  CHECK_THROWS_MATCHES(page.confirm(read), WorkError, Refused(Cause::kBusy, "by now"));
  CHECK_FALSE(person->entered());
  person->show("the board is gone");
  page.confirm(board.state().advice);
  CHECK(person->entered());
}

}  // namespace
}  // namespace planar
