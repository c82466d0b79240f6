#include "text/atomic_file.h"

#include <catch2/catch.hpp>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("A written file is whole and leaves no temporary behind") {
  const test::TemporaryFolder folder;
  write_file(folder / "a.txt", "first");
  write_file(folder / "a.txt", "second");
  CHECK(read_file(folder / "a.txt") == "second");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A place that cannot be written is named and nothing is left") {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "absent" / "a.txt";
  CHECK_THROWS_WITH(write_file(path, "text"), Contains("absent/a.txt: cannot be written"));
  CHECK_THROWS_WITH(read_file(path), Contains("absent/a.txt: cannot be read"));
  CHECK_THROWS_WITH(read_file(folder.path()), Contains("is a folder"));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("An output that is an input is refused") {
  const test::TemporaryFolder folder;
  const auto input = folder.write("in.csv", "x");
  CHECK_THROWS_AS(require_not_input(folder / "./in.csv", input), InputError);
  CHECK_NOTHROW(require_not_input(folder / "out.csv", input));
}

}  // namespace
}  // namespace planar
