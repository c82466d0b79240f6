#include "planar_servo/base/core/error.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("A refusal's text has its place in front and its remedy behind, where it has them") {
  CHECK(Refusal{"is empty"}.text() == "is empty");
  CHECK(Refusal{"is empty", "fill it"}.text() == "is empty; fill it");
  CHECK(Refusal{"is empty", "", "a.csv"}.text() == "a.csv: is empty");
  CHECK(Refusal{"is empty", "fill it", "a.csv:3"}.text() == "a.csv:3: is empty; fill it");
}

TEST_CASE("A refusal is placed within what holds it") {
  const Refusal fault{"is 'x'", "a number is needed"};
  CHECK(fault.at("a.csv") == Refusal{"is 'x'", "a number is needed", "a.csv"});
  CHECK(fault.at("line 3").at("a.csv").where == "a.csv: line 3");
  CHECK(Refusal{"is held", "", "", Cause::kBusy}.at("a.csv").cause == Cause::kBusy);
}

TEST_CASE("Errors keep their refusal as data and say its text") {
  const Refusal refusal{"is a folder", "name a file", "out"};
  CHECK(InputError(refusal).refusal() == refusal);
  CHECK(std::string(InputError(refusal).what()) == "out: is a folder; name a file");
  CHECK(InputError("a sentence; not taken apart").refusal() ==
        Refusal{"a sentence; not taken apart"});
  CHECK(WorkError(refusal).refusal() == refusal);
  CHECK(InputError("is gone").refusal().cause == Cause::kInvalid);
  CHECK(WorkError("is gone", Cause::kMissing).refusal().cause == Cause::kMissing);
}

/// Returns what throw_if_any() throws.
InputError thrown(const Faults& faults,
                  std::size_t rows = std::numeric_limits<std::size_t>::max()) {
  try {
    faults.throw_if_any(rows);
  } catch (const InputError& error) {
    return error;
  }
  return InputError("nothing");
}

TEST_CASE("Faults are thrown together, each once, on a line of its own") {
  Faults faults;
  CHECK(faults.empty());
  CHECK_NOTHROW(faults.throw_if_any());
  faults.add({"is empty", "fill it", "a.csv:1"});
  faults.add({"is empty", "fill it", "a.csv:2"});
  faults.add({"is empty", "fill it", "a.csv:1"});
  const InputError error = thrown(faults);
  REQUIRE(error.refusals().size() == 2);
  CHECK(error.refusals()[1].where == "a.csv:2");
  CHECK(std::string(error.what()) == "a.csv:1: is empty; fill it\na.csv:2: is empty; fill it");
}

TEST_CASE("Faults beyond a hundred are counted") {
  Faults faults;
  for (int line = 1; line <= 103; ++line) faults.add({"is empty", "", std::to_string(line)});
  const InputError error = thrown(faults);
  CHECK(error.refusals().size() == 100);
  CHECK_THAT(error.what(), Catch::EndsWith("100: is empty\n... and 3 more"));
}

Refusal no_number(int row) {
  return {"x is '" + std::to_string(row) + "a'", "a number is needed", std::to_string(row)};
}

TEST_CASE("Of a fault that all rows have, the first three are told, and how many more there are") {
  Faults faults;
  for (int row = 1; row <= 8; ++row) {
    faults.add(no_number(row), "x");
    if (row == 7) faults.add({"y is ''", "a number is needed", "7"}, "y");
  }
  CHECK_THROWS_WITH(faults.throw_if_any(8),
                    "1: x is '1a'; a number is needed\n2: x is '2a'; a number is needed\n3: x is "
                    "'3a'; a number is needed\n7: y is ''; a number is needed\n... and 5 more");
}

TEST_CASE("A fault that a row does not have is told of every other row") {
  Faults faults;
  for (int row = 1; row <= 8; ++row)
    if (row != 4) faults.add(no_number(row), "x");
  CHECK_THROWS_WITH(faults.throw_if_any(8), Contains("8: x is '8a'") && !Contains("more"));
}

TEST_CASE("Faults are alike by column and rule, not by their sentences") {
  Faults faults;
  for (int row = 1; row <= 8; ++row) {
    faults.add({"has " + std::to_string(row) + " of 9 fields", "the header has 9"});
    faults.add({"don't know '" + std::to_string(row) + "'", "needed is a"}, row < 5 ? "x" : "y");
  }
  const std::string text = thrown(faults, 8).what();
  CHECK_THAT(text, Contains("has 3 of 9") && !Contains("has 4 of 9"));
  CHECK_THAT(text, Contains("know '8'") && Contains("... and 5 more"));
}

}  // namespace
}  // namespace planar
