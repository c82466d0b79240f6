#include <catch2/catch.hpp>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/console/arm_jobs.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("Only a virtual cell is experimented on, in a folder of its own") {
  const test::TemporaryFolder folder;
  const auto paper = test::paper_cell_file();
  const std::string text = read_file(paper);
  folder.write("truth.yaml", read_file(paper.parent_path() / "truth.yaml"));
  const KnownCell cell(folder.write("cell.yaml", text));
  const KnownCell real(folder.write("real.yaml", test::replaced(text, "virtual: truth.yaml", "")));
  StateBoard board;
  CellWorker worker(cell, board, [] { return false; });
  ConsoleJobs jobs{cell, board, worker, [] {}}, at_real{real, board, worker, [] {}};
  CHECK_THROWS_MATCHES(begin_experiment(at_real, "experiment", 0), InputError,
                       Refused(Cause::kInvalid, "real.yaml"));
  CHECK_THROWS_MATCHES(begin_experiment(jobs, "../experiment", 0), InputError,
                       Refused(Cause::kInvalid, "'../experiment'"));
  CHECK(real.json()["virtual"] == false);
  CHECK(cell.json()["virtual"] == true);
  CHECK_FALSE(board.state().job);
}

}  // namespace
}  // namespace planar
