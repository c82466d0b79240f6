#include "planar_servo/io/growing_file.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("A growing file begins with its header, also in an empty file, and is gone on with") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("steps.csv", "");
  GrowingFile(file, "id\n").append("a\n");
  GrowingFile(file, "id\n").append("b\n");
  CHECK(read_file(file) == "id\na\nb\n");
}

TEST_CASE("What cannot grow is refused before the first line is there") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(GrowingFile(folder.path(), "id\n"),
                    Contains("cannot be added to; a file that"));
  CHECK_THROWS_AS(GrowingFile(folder.path(), "id\n"), InputError);
  CHECK_THROWS_WITH(GrowingFile(folder.path() / "absent" / "steps.csv", "id\n"),
                    Contains("steps.csv: cannot be written: there is no folder"));
}

}  // namespace
}  // namespace planar
