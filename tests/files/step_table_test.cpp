#include "planar_servo/tables/step_table.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "support/temporary_folder.h"

namespace planar {
namespace {

long commas(const std::string& text) {
  return std::count(text.begin(), text.end(), ',');
}

TEST_CASE("Every step has one field per column, measured or not") {
  const std::string header = steps_header();
  const std::string columns = header.substr(header.find('\n') + 1);
  ServoStep step;
  step.measurement.lamps_px.fill(Eigen::Vector2d::Zero());
  CHECK(commas(step_line("a", step)) == commas(columns));
  step.measurement = failed_look(TipStatus::kNoLamps, "one_lamp", 0.0);
  CHECK(commas(step_line("a", step)) == commas(columns));
}

TEST_CASE("The errors of steps are read back, with none where the tool was not seen") {
  const test::TemporaryFolder folder;
  ServoStep seen, unseen;
  seen.iteration = 2;
  seen.error = {0.003e-3, 0.004e-3};
  unseen.measurement = failed_look(TipStatus::kNoLamps, "one_lamp", 0.0);
  const auto file =
      folder.write("steps.csv", steps_header() + step_line("a", seen) + step_line("b", unseen));
  const std::vector<StepError> steps = read_step_errors(file);
  REQUIRE(steps.size() == 2);
  CHECK((steps[0].target == "a" && steps[0].step == 2));
  CHECK(steps[0].error.value() == Approx(0.005e-3));
  CHECK((steps[1].target == "b" && !steps[1].error));
  CHECK_THROWS_WITH(read_step_errors(folder.write("bad.csv", steps_header() + "a,one\n")),
                    Catch::Contains("bad.csv:3"));
}

}  // namespace
}  // namespace planar
