#include "planar_servo/experiment/paper_cell.h"

#include <catch2/catch.hpp>

#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/sha256.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

// The truth of the paper's cell was set once, by the figures of the paper's chain alone, and is
// frozen: an estimator that does better must not be helped by a change of what it is judged by.
constexpr char kFrozenTruth[] = "a5651b394d2e91a9bdbc5ac196e4429227000aa320ba4c76c363683643579318";

TEST_CASE("The truth of the paper's cell is the one that was frozen, as its page says") {
  const auto folder = test::paper_cell_file().parent_path();
  CHECK(sha256(read_file(folder / "truth.yaml")) == kFrozenTruth);
  CHECK_THAT(read_file(folder / "../../doc/experiment.md"), Catch::Contains(kFrozenTruth));
}

TEST_CASE("Drawn cells get the paper's cell file") {
  CHECK(read_file(test::paper_cell_file()) == paper_cell_text());
}

}  // namespace
}  // namespace planar
