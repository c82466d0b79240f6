#include "planar_servo/io/atomic_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
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

TEST_CASE("A link stays and the file behind it is replaced") {
  const test::TemporaryFolder folder;
  folder.write("real.txt", "first");
  std::filesystem::create_symlink("real.txt", folder / "link.txt");
  write_file(folder / "link.txt", "second");
  CHECK(std::filesystem::is_symlink(folder / "link.txt"));
  CHECK(read_file(folder / "real.txt") == "second");
}

TEST_CASE("A link planted under the temporary's name is not followed") {
  const test::TemporaryFolder folder;
  folder.write("precious.txt", "precious");
  const std::string part = "a.txt.part" + std::to_string(getpid());
  std::filesystem::create_symlink("precious.txt", folder / part);
  write_file(folder / "a.txt", "text");
  CHECK(read_file(folder / "precious.txt") == "precious");
  CHECK(read_file(folder / "a.txt") == "text");
  CHECK_FALSE(std::filesystem::is_symlink(folder / "a.txt"));
}

TEST_CASE("A file of one kind does not take the place of another") {
  const test::TemporaryFolder folder;
  const auto cell = folder.write("cell.yaml", "format: planar-servo/cell/1\na: 1\n");
  const auto pairs = folder.write("pairs.csv", "# format: planar-servo/pairs/1\nid\n");
  CHECK_THROWS_WITH(write_file(cell, "format: planar-servo/error-map/1\n"),
                    Contains("is a file of planar-servo/cell, which this output would replace"));
  CHECK_THROWS_AS(write_file(pairs, "<html>"), InputError);
  CHECK_THROWS_WITH(require_writable(cell), Contains("name another file"));
  CHECK_NOTHROW(require_writable(pairs));
  write_file(pairs, "# format: planar-servo/pairs/1\nid,x_mm\n");
  write_file(cell, "format: planar-servo/cell/1\na: 2\n");
  CHECK_THAT(read_file(cell), Contains("a: 2"));
}

TEST_CASE("A device is written as it stands") {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/null", folder / "nowhere");
  write_file(folder / "nowhere", "text");
  CHECK(std::filesystem::is_character_file("/dev/null"));
  CHECK_NOTHROW(require_writable(folder / "nowhere"));
}

TEST_CASE("A place that could not be written is refused before the work") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("a.txt", "text");
  CHECK_NOTHROW(require_writable(file));
  CHECK_NOTHROW(require_writable(folder / "new.txt"));
  CHECK_NOTHROW(require_writable("new.txt"));
  CHECK_THROWS_WITH(require_writable(folder.path()), Contains("is a folder"));
  CHECK_THROWS_WITH(require_writable(file / "b.txt"), Contains("there is no folder"));
  CHECK_THROWS_AS(require_writable(folder / "absent/b.txt"), InputError);
}

TEST_CASE("An output that is an input is refused") {
  const test::TemporaryFolder folder;
  const auto input = folder.write("in.csv", "x");
  CHECK_THROWS_AS(require_not_input(folder / "./in.csv", input), InputError);
  CHECK_NOTHROW(require_not_input(folder / "out.csv", input));
}

TEST_CASE("Two outputs that are one file are refused, however they are spelt") {
  CHECK_THROWS_WITH(require_own_names({"map.yaml", "./map.yaml"}), Contains("two outputs"));
  CHECK_NOTHROW(require_own_names({"map.yaml", "arm.yaml", "", ""}));
}

}  // namespace
}  // namespace planar
