#include "planar_servo/base/io/checksum.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

std::string map_with(double weight) {
  return YamlWriter("map", "test").add("weight", weight).text();
}

double weight_in(const std::filesystem::path& path) {
  YamlReader reader(path, "map");
  double weight = 0.0;
  reader.number("weight", weight);
  reader.throw_if_faulty();
  return weight;
}

TEST_CASE("A calibration file that was changed after it had been written is refused") {
  const test::TemporaryFolder folder;
  const std::string text = map_with(0.25);
  CHECK(weight_in(folder.write("map.yaml", text)) == 0.25);
  const auto changed = folder.write("map.yaml", test::replaced(text, "0.25", "0.251"));
  CHECK_THROWS_AS(weight_in(changed), InputError);
  CHECK_THROWS_MATCHES(weight_in(changed), InputError,
                       Refused(Cause::kForeign, "--seal " + changed.string()));
  CHECK_THROWS_AS(weight_in(folder.write("map.yaml", text + "# a note\n")), InputError);
  CHECK_THROWS_AS(weight_in(folder.write("map.yaml", "# a note\n" + text)), InputError);
}

TEST_CASE("Every kind of calibration file is written with a checksum") {
  const std::string kind = GENERATE(as<std::string>(), "camera", "workplane", "tool", "map",
                                    "health", "arm", "arm_learned");
  CHECK_THAT(YamlWriter(kind, "test").text(), Contains("\nchecksum: \""));
}

TEST_CASE("The time at which a file was made is no part of its checksum") {
  const test::TemporaryFolder folder;
  const std::string later = test::replaced(map_with(0.25), "created: \"2", "created: \"3");
  CHECK(weight_in(folder.write("map.yaml", later)) == 0.25);
}

TEST_CASE("A file without a checksum is accepted, and one of what people write has none") {
  const test::TemporaryFolder folder;
  CHECK(weight_in(folder.write("map.yaml", "format: planar-servo/map/1\nweight: 2\n")) == 2.0);
  CHECK_THAT(YamlWriter("truth", "test").text(), !Contains("checksum"));
  CHECK_THAT(YamlWriter().add("a", 1).text(), !Contains("checksum"));
}

TEST_CASE("Who edits a file by hand seals it, and the file says so under its checksum") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("map.yaml", test::replaced(map_with(0.25), "0.25", "0.5"));
  CHECK(seal_by_hand(file));
  CHECK(weight_in(file) == 0.5);
  const std::string sealed = read_file(file);
  CHECK_THAT(sealed, Contains("\nedited_by_hand: \"2") && Contains("\ncreated: "));
  CHECK_FALSE(seal_by_hand(file));
  CHECK(read_file(file) == sealed);
  folder.write("map.yaml", test::replaced(sealed, "edited_by_hand", "# edited"));
  CHECK_THROWS_AS(weight_in(file), InputError);
}

TEST_CASE("A seal is no part of the content by which other files name one") {
  const std::string text = map_with(0.25);
  const std::string bare = "format: planar-servo/map/1\nweight: 2\n";
  CHECK(content_sha256_of(with_checksum(bare)) == content_sha256_of(bare));
  CHECK(with_checksum(text) == text);
}

TEST_CASE("What is no calibration file is not sealed") {
  const test::TemporaryFolder folder;
  const auto cell = folder.write("cell.yaml", "format: planar-servo/cell/1\na: 1\n");
  CHECK_THROWS_MATCHES(seal_by_hand(cell), InputError, Refused(Cause::kInvalid, "cell.yaml"));
  CHECK_THROWS_AS(seal_by_hand(folder.write("a.csv", "a,b\n")), InputError);
  CHECK(read_file(cell) == "format: planar-servo/cell/1\na: 1\n");
}

}  // namespace
}  // namespace planar
