#include "planar_servo/core/error.h"

#include <catch2/catch.hpp>
#include <string>

namespace planar {
namespace {

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
}

TEST_CASE("Errors keep their refusal as data and say its text") {
  const Refusal refusal{"is a folder", "name a file", "out"};
  CHECK(InputError(refusal).refusal() == refusal);
  CHECK(std::string(InputError(refusal).what()) == "out: is a folder; name a file");
  CHECK(InputError("a sentence; not taken apart").refusal() ==
        Refusal{"a sentence; not taken apart"});
  CHECK(WorkError(refusal).refusal() == refusal);
}

/// Returns what throw_if_any() throws.
InputError thrown(const Faults& faults) {
  try {
    faults.throw_if_any();
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

}  // namespace
}  // namespace planar
