#include "planar_servo/base/io/atomic_file.h"

#include <unistd.h>

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

TEST_CASE("A written file is whole and leaves no temporary behind") {
  const test::TemporaryFolder folder;
  write_file(folder / "map.yaml", "format: planar-servo/map/1\na: 1\n");
  write_file(folder / "map.yaml", "format: planar-servo/map/1\na: 2\n");
  CHECK(read_file(folder / "map.yaml") == "format: planar-servo/map/1\na: 2\n");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A place that cannot be written is named and nothing is left") {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "absent" / "a.txt";
  CHECK_THROWS_MATCHES(write_file(path, "text"), WorkError,
                       Refused(Cause::kSystem, "absent/a.txt"));
  CHECK_THROWS_MATCHES(read_file(path), InputError, Refused(Cause::kMissing, "absent/a.txt"));
  CHECK_THROWS_MATCHES(read_file(folder.path()), InputError,
                       Refused(Cause::kInvalid, folder.path().string()));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Nothing is written through a link, wherever it leads") {
  const test::TemporaryFolder folder;
  const std::string text = "format: planar-servo/map/1\n";
  folder.write("real.yaml", text);
  for (const char* target : {"real.yaml", "absent.yaml"}) {
    const auto link = folder / (std::string("link_to_") + target);
    std::filesystem::create_symlink(target, link);
    CHECK_THROWS_MATCHES(write_file(link, text), InputError, Refused(Cause::kInvalid, "link_to_"));
    CHECK_THROWS_AS(require_writable(link, "map"), InputError);
  }
  CHECK(read_file(folder / "real.yaml") == text);
  CHECK_FALSE(std::filesystem::exists(folder / "absent.yaml"));
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
  CHECK_THROWS_MATCHES(write_file(cell, "format: planar-servo/error-map/1\n"), InputError,
                       Refused(Cause::kExists, "cell.yaml"));
  CHECK_THROWS_AS(write_file(pairs, "<html>"), InputError);
  CHECK_THROWS_MATCHES(require_writable(cell, "cell"), InputError,
                       Refused(Cause::kExists, "cell.yaml"));
  CHECK_THROWS_AS(require_writable(pairs, "map"), InputError);
  CHECK_NOTHROW(require_writable(pairs, "pairs"));
  write_file(pairs, "# format: planar-servo/pairs/1\nid,x_mm\n");
  write_file(cell, "format: planar-servo/cell/1\na: 2\n");
  CHECK_THAT(read_file(cell), Contains("a: 2"));
}

TEST_CASE("A file that is not ours is never replaced, unless it is empty") {
  const test::TemporaryFolder folder;
  const auto targets = folder.write("targets.csv", "id,x_mm,y_mm\na,1,2\n");
  CHECK_THROWS_MATCHES(write_file(targets, "# format: planar-servo/plan/1\nid\n"), InputError,
                       Refused(Cause::kExists, "targets.csv"));
  CHECK_THROWS_AS(require_writable(targets, "plan"), InputError);
  CHECK_THROWS_AS(write_file(targets, "text"), InputError);
  CHECK(read_file(targets) == "id,x_mm,y_mm\na,1,2\n");
  const auto empty = folder.write("empty.csv", "");
  CHECK_NOTHROW(require_writable(empty, "plan"));
  write_file(empty, "text");
  CHECK(read_file(empty) == "text");
}

TEST_CASE("Every form of our files says its kind where it begins") {
  CHECK(kind_of_text("format: planar-servo/map/1\na: 1\n") == "map");
  CHECK(kind_of_text("# format: planar-servo/steps/1\nid\n") == "steps");
  CHECK(kind_of_text("<!DOCTYPE html>\n" + format_comment("page") + "<html>") == "page");
  CHECK(kind_of_text("P5\n2 2\n255\n") == "image");
  CHECK(kind_of_text(with_format_key("figures", "{\n  \"a\": 1\n}")) == "figures");
  CHECK(with_format_key("figures", "{}") == "{\n  \"format\": \"planar-servo/figures/1\"\n}\n");
  CHECK(kind_of_text("{\"format\":\"planar-servo/campaign/1\",\"a\":1}\n") == "campaign");
  CHECK(kind_of_text("{\"a\": 1}").empty());
  CHECK(kind_of_text("see format: planar-servo/map/1\n").empty());
  CHECK(kind_of_text("").empty());
}

TEST_CASE("A device is written as it stands") {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/null", folder / "nowhere");
  write_file(folder / "nowhere", "text");
  CHECK(std::filesystem::is_character_file("/dev/null"));
  CHECK_NOTHROW(require_writable(folder / "nowhere", "map"));
}

TEST_CASE("A file whose reading fails on the way is refused, never taken as a shorter one") {
  CHECK_THROWS_MATCHES(read_file("/proc/self/mem"), InputError,
                       Refused(Cause::kSystem, "/proc/self/mem"));
}

TEST_CASE("A place that could not be written is refused before the work") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("map.yaml", "format: planar-servo/map/1\n");
  CHECK_NOTHROW(require_writable(file, "map"));
  CHECK_NOTHROW(require_writable(folder / "new.yaml", "map"));
  CHECK_NOTHROW(require_writable("new.yaml", "map"));
  CHECK_THROWS_MATCHES(require_writable(folder.path(), "map"), InputError,
                       Refused(Cause::kInvalid, folder.path().string()));
  CHECK_THROWS_MATCHES(require_writable(file / "b.yaml", "map"), InputError,
                       Refused(Cause::kMissing, "b.yaml"));
  CHECK_THROWS_AS(require_writable(folder / "absent/b.yaml", "map"), InputError);
}

TEST_CASE("An output that is an input is refused") {
  const test::TemporaryFolder folder;
  const auto input = folder.write("in.csv", "x");
  CHECK_THROWS_AS(require_not_input(folder / "./in.csv", input), InputError);
  CHECK_NOTHROW(require_not_input(folder / "out.csv", input));
}

TEST_CASE("Two outputs that are one file are refused, however they are spelt") {
  CHECK_THROWS_MATCHES(require_outputs({{"map.yaml", "map"}, {"./map.yaml", "map"}}, {}),
                       InputError, Refused(Cause::kExists, "map.yaml"));
  CHECK_NOTHROW(
      require_outputs({{"map.yaml", "map"}, {"arm.yaml", "arm"}, {"", "map"}, {"", "map"}}, {}));
}

}  // namespace
}  // namespace planar
