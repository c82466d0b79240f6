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

TEST_CASE("A row that was torn by a crash is cut off, and only that") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("steps.csv", "id,x\na,1\nb,2.7");
  GrowingFile(file, "id,x\n").append("b,2.75\n");
  CHECK(read_file(file) == "id,x\na,1\nb,2.75\n");
  const auto whole = folder.write("whole.csv", "id,x\na,1\n");
  drop_torn_line(whole);
  CHECK(read_file(whole) == "id,x\na,1\n");
  const auto torn_header = folder.write("header.csv", "id,");
  GrowingFile(torn_header, "id,x\n").append("a,1\n");
  CHECK(read_file(torn_header) == "id,x\na,1\n");
  CHECK_NOTHROW(drop_torn_line(folder.path() / "absent.csv"));
}

TEST_CASE("A file that begins otherwise is not continued where its header is asked for") {
  const test::TemporaryFolder folder;
  CHECK_NOTHROW(require_header(folder / "absent.csv", "id\n"));
  CHECK_NOTHROW(require_header(folder.write("steps.csv", "id\na\n"), "id\n"));
  CHECK_THROWS_WITH(require_header(folder.write("other.csv", "name\na\n"), "id\n"),
                    Contains("other.csv: holds something else already"));
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
