#include <catch2/catch.hpp>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

// A truth is frozen before any estimator runs on it (that of the paper's cell was set by the
// figures of the paper's chain alone): an estimator that does better must not be helped by a change
// of what it is judged by.
struct FrozenTruth {
  const char* cell;
  const char* sha256;
};
constexpr FrozenTruth kFrozen[] = {
    {"paper", "a5651b394d2e91a9bdbc5ac196e4429227000aa320ba4c76c363683643579318"},
    {"hard", "c6fc5c3874c88160b7a05a51f51b65a67cbabc311ce04f20543ae93f24b784f3"},
    {"small", "ebf061b30b4df57555be7ae5024a8cbafc54ff4967a5e71e9ca7d53d73aa7efd"},
    {"ordinary", "8cf57853c9f5c9910860d51c9f635d1605d4c15581b80d988ebe590e280287e2"},
    {"cheap", "1c4a1f9bf29e8fa02c016b16694d73adf96ddbae992315c81175e5152d701c78"}};

TEST_CASE("The truths of the cells are those that were frozen, as their page says") {
  const auto calib = test::paper_cell_file().parent_path().parent_path();
  for (const auto& [cell, hash] : kFrozen) {
    INFO(cell);
    CHECK(sha256(read_file(calib / cell / "truth.yaml")) == hash);
    CHECK_THAT(read_file(calib / "../doc/virtual_cell.md"), Catch::Contains(hash));
  }
}

}  // namespace
}  // namespace planar
