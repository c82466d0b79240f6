#include "planar_servo/base/io/atomic_file.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A growing file begins with its header, also in an empty file, and is appended to") {
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
  drop_torn_line(whole, "id,x\n");
  CHECK(read_file(whole) == "id,x\na,1\n");
  CHECK_NOTHROW(drop_torn_line(folder.path() / "absent.csv", "id,x\n"));
}

TEST_CASE("A table may have remarks of its own, but no other columns") {
  const test::TemporaryFolder folder;
  const std::string format = "# format: planar-servo/steps/1\n", own = "# of an earlier run\n";
  GrowingFile(folder.write("steps.csv", format + own + "id,x\na,1\n"), format + "id,x\n");
  CHECK_THROWS_AS(GrowingFile(folder.write("steps.csv", format + "id\na\n"), format + "id,x\n"),
                  InputError);
}

TEST_CASE("What does not begin with the header's first line is neither cut nor added to") {
  const test::TemporaryFolder folder;
  const std::string header = "# format: planar-servo/steps/1\nid,x\n";
  for (const char* text :
       {"a letter without a line end", "id,x\na,1\nb,2.7", "# format: planar-"}) {
    const auto file = folder.write("steps.csv", text);
    CHECK_THROWS_MATCHES(GrowingFile(file, header), InputError,
                         Refused(Cause::kForeign, "steps.csv"));
    CHECK_THROWS_AS(drop_torn_line(file, header), InputError);
    CHECK(read_file(file) == text);
  }
}

TEST_CASE("A table does not grow through a link, not even one that is planted while it grows") {
  const test::TemporaryFolder folder;
  const auto real = folder.write("real.csv", "id\na");
  std::filesystem::create_symlink(real, folder / "steps.csv");
  CHECK_THROWS_MATCHES(GrowingFile(folder / "steps.csv", "id\n"), InputError,
                       Refused(Cause::kInvalid, "steps.csv"));
  CHECK_THROWS_AS(drop_torn_line(folder / "steps.csv", "id\n"), InputError);
  GrowingFile table(folder / "table.csv", "id\n");
  std::filesystem::remove(folder / "table.csv");
  std::filesystem::create_symlink(real, folder / "table.csv");
  CHECK_THROWS_AS(table.append("b\n"), WorkError);
  CHECK(read_file(real) == "id\na");
}

TEST_CASE("A file that begins otherwise is not continued where its header is asked for") {
  const test::TemporaryFolder folder;
  CHECK_NOTHROW(require_header(folder / "absent.csv", "id\n"));
  CHECK_NOTHROW(require_header(folder.write("steps.csv", "id\na\n"), "id\n"));
  CHECK_THROWS_MATCHES(require_header(folder.write("other.csv", "name\na\n"), "id\n"), InputError,
                       Refused(Cause::kForeign, "other.csv"));
}

TEST_CASE("What cannot grow is refused before the first line is there") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(GrowingFile(folder.path(), "id\n"), InputError,
                       Refused(Cause::kSystem, folder.path().string()));
  CHECK_THROWS_AS(GrowingFile(folder.path(), "id\n"), InputError);
  CHECK_THROWS_MATCHES(GrowingFile(folder.path() / "absent" / "steps.csv", "id\n"), InputError,
                       Refused(Cause::kMissing, "steps.csv"));
}

}  // namespace
}  // namespace planar
