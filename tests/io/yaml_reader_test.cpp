#include "planar_servo/base/io/yaml_reader.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

/// The faults of what was read; without any when there are none.
InputError faults_of(YamlReader& reader) {
  try {
    reader.throw_if_faulty();
  } catch (const InputError& e) {
    return e;
  }
  return InputError(std::vector<Refusal>(), 0);
}

TEST_CASE("A strict document gives its values and has no faults") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("a.yaml",
                                 "format: planar-servo/cell/1\nservo: {gain: 0.5, law: jacobian}\n"
                                 "n: 3\nlist: [1, 2]\nitems: [{x: 1}, {x: 2}]\n");
  YamlReader reader(path, "cell");
  double gain = 0.0;
  std::string law;
  int n = 0;
  std::vector<double> list, items;
  reader.map("servo", [&] {
    reader.number("gain", gain);
    reader.choice("law", law, {"jacobian", "inverse"});
  });
  reader.whole_number("n", n, 1);
  reader.numbers("list", list, 2);
  reader.maps("items", items, [&](double& x) { reader.number("x", x); });
  CHECK(gain == 0.5);
  CHECK(law == "jacobian");
  CHECK(n == 3);
  CHECK(list == std::vector<double>{1.0, 2.0});
  CHECK(items == list);
  CHECK_FALSE(reader.given("absent"));
  CHECK_NOTHROW(reader.throw_if_faulty());
}

TEST_CASE("A file too large for memory is refused before it is read") {
  const test::TemporaryFolder folder;
  const std::string begin = "format: planar-servo/cell/1\nn: 3\n#";
  const auto path = folder.write("a.yaml", begin + std::string(16'000'000, 'x'));
  CHECK_THROWS_MATCHES(YamlReader(path, "cell"), InputError, Refused(Cause::kInvalid, "16.0 MB"));
  CHECK_NOTHROW(YamlReader(folder.write("b.yaml", begin + std::string(15'000'000, 'x')), "cell"));
}

TEST_CASE("All faults of a file are named at once, each with its place and what is allowed") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("cell.yaml",
                                 "format: planar-servo/cell/1\n"
                                 "servo: {gian: 1.0, law: magic, tolerance_mm: .nan}\n"
                                 "size: [1, two]\nsize: [1, 2]\n");
  YamlReader reader(path, "cell");
  double gain = 0.0, tolerance = 0.0;
  std::string law;
  std::vector<double> size;
  reader.map("servo", [&] {
    reader.number("gain", gain);
    reader.choice("law", law, {"jacobian", "inverse"});
    reader.number("tolerance_mm", tolerance);
  });
  reader.numbers("size", size, 2);
  const InputError faults = faults_of(reader);
  CHECK_THAT(faults, Refused(Cause::kMissing, "cell.yaml:2:8: "));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "cell.yaml:2:9: "));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "gain, law"));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "cell.yaml:2:25: servo.law"));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "jacobian, inverse"));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "servo.tolerance_mm is '.nan'"));
  CHECK_THAT(faults, Refused(Cause::kInvalid, "cell.yaml:3:11: size[1]"));
  CHECK_THAT(faults, Refused(Cause::kExists, "cell.yaml:4:1: "));
}

TEST_CASE("Keys of a missing map do not add faults of their own") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("a.yaml", "format: planar-servo/cell/1\n");
  YamlReader reader(path, "cell");
  double width = 0.0;
  reader.map("camera", [&] { CHECK_FALSE(reader.number("width_px", width)); });
  CHECK(width == 0.0);
  const InputError faults = faults_of(reader);
  CHECK(faults.refusals().size() == 1);
  CHECK_THAT(faults, Refused(Cause::kMissing, "'camera'"));
}

TEST_CASE("A number outside its range is a fault that names the range") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("a.yaml", "format: planar-servo/cell/1\ngain: 7\n");
  YamlReader reader(path, "cell");
  double gain = 0.5;
  CHECK_FALSE(reader.number("gain", gain, 1.0, Range::from_to(0.0, 1.0)));
  CHECK(gain == 0.5);
  CHECK_THAT(faults_of(reader), Refused(Cause::kInvalid, "from 0 to 1"));
}

/// The only fault of reading `value` at the key `n`.
InputError fault_of(const std::string& value, const std::function<void(YamlReader&)>& read) {
  const test::TemporaryFolder folder;
  YamlReader reader(folder.write("a.yaml", "format: planar-servo/cell/1\nn: " + value), "cell");
  read(reader);
  InputError faults = faults_of(reader);
  CHECK(faults.refusals().size() <= 1);
  return faults;
}

TEST_CASE("No range shows a bound that no file reaches") {
  double n = 0.0;
  const auto number_in = [&n](const Range& range) {
    return [&n, range](YamlReader& reader) { reader.number("n", n, 1.0, range); };
  };
  const auto at_least_2 = number_in(Range::at_least(2.0));
  const auto positive = number_in(Range::positive()), share = number_in(Range::positive(1.0));
  CHECK_THAT(fault_of("1.5", at_least_2).what(),
             Contains("n is 1.5; a number of at least 2 is needed"));
  CHECK_THAT(fault_of("-1", positive).what(), Contains("n is -1; a positive number is needed"));
  CHECK_THAT(fault_of("0", positive).what(), Contains("n is 0; a positive number is needed"));
  CHECK_THAT(fault_of("2", share).what(),
             Contains("n is 2; a positive number of at most 1 is needed"));
  CHECK(fault_of("1e-3", positive).refusals().empty());
}

TEST_CASE("A whole number has no fraction, and is refused outside its range") {
  int n = 0;
  std::uint32_t large = 0;
  const auto from_1_to_9 = [&](YamlReader& reader) { reader.whole_number("n", n, 1, 9); };
  const auto from_1 = [&](YamlReader& reader) { reader.whole_number("n", n, 1); };
  const auto seed = [&](YamlReader& reader) { reader.whole_number("n", large, std::uint32_t{0}); };
  CHECK_THAT(fault_of("1280.7", from_1), Refused(Cause::kInvalid, "n is 1280.7"));
  CHECK_THAT(fault_of("2.9", from_1), Refused(Cause::kInvalid, "n is 2.9"));
  CHECK_THAT(fault_of("1e12", seed), Refused(Cause::kInvalid, "from 0 to 4294967295"));
  CHECK_THAT(fault_of(".nan", from_1), Refused(Cause::kInvalid, "n is '.nan'"));
  CHECK_THAT(fault_of("", from_1), Refused(Cause::kInvalid, "n is empty"));
  CHECK(fault_of("4294967295", seed).refusals().empty());
  CHECK_THAT(fault_of("0", from_1), Refused(Cause::kInvalid, "n is 0"));
  CHECK_THAT(fault_of("10", from_1_to_9), Refused(Cause::kInvalid, "from 1 to 9"));
  CHECK(fault_of("5.0", from_1_to_9).refusals().empty());
}

TEST_CASE("A malformed list tells its reader that there is none") {
  using Couple = std::array<double, 2>;
  std::vector<Couple> rows;
  const auto read_rows = [&](YamlReader& reader) {
    return reader.rows("n", rows, [](RowFields& row, Couple& values) {
      for (double& value : values) row.number(value);
    });
  };
  for (const char* list : {"[[1, two]]", "[[1]]", "[1]", "[{a: 1}]"}) {
    const auto read = [&](YamlReader& reader) { CHECK_FALSE(read_rows(reader)); };
    CHECK_THAT(fault_of(list, read), Refused(Cause::kInvalid, "n[0]"));
  }
  CHECK(fault_of("[[1, 2]]", read_rows).refusals().empty());
  CHECK(rows == std::vector<Couple>{{1.0, 2.0}});
}

TEST_CASE("A map that may have any keys adds no fault for those nobody asked for") {
  const std::string map = "{kind: vritual, gear: 3}";
  const auto ask = [](YamlReader& reader) { reader.map("n", [&] { reader.given("kind"); }); };
  const auto read_kind = [](YamlReader& reader) {
    std::string kind;
    reader.map("n", [&] {
      reader.choice("kind", kind, {"virtual", "tic"});
      reader.allow_rest();
    });
  };
  CHECK_THAT(fault_of("{gear: 3}", ask), Refused(Cause::kInvalid, "'n.gear'"));
  CHECK_THAT(fault_of(map, read_kind), Refused(Cause::kInvalid, "n.kind is 'vritual'"));
}

TEST_CASE("A file that is missing, empty, broken or of another kind is refused by name") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    YamlReader(folder.write("f.yaml", text), "cell");
  };
  CHECK_THROWS_MATCHES(YamlReader(folder / "no.yaml", "cell"), InputError,
                       Refused(Cause::kMissing, "no.yaml"));
  CHECK_THROWS_MATCHES(read(""), InputError, Refused(Cause::kInvalid, "f.yaml: "));
  CHECK_THROWS_MATCHES(read("a: [1"), InputError, Refused(Cause::kInvalid, "f.yaml:1:"));
  CHECK_THROWS_MATCHES(read("format: planar-servo/map/1\n"), InputError,
                       Refused(Cause::kForeign, "'planar-servo/map/1'"));
  CHECK_THROWS_MATCHES(read("a: 1\n"), InputError, Refused(Cause::kMissing, "f.yaml:1:1"));
}

TEST_CASE("A lenient document takes keys that nobody asked for") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("a.yaml", "other: 1\nwanted: 2\n");
  YamlReader reader(path);
  double wanted = 0.0;
  reader.number("wanted", wanted);
  CHECK(wanted == 2.0);
  CHECK_NOTHROW(reader.throw_if_faulty());
}

}  // namespace
}  // namespace planar
