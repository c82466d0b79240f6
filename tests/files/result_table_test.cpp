#include "planar_servo/files/tables/result_table.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

TargetResult sample() {
  TargetResult result;
  result.id = "a";
  result.p_d = {0.2, -0.1};
  result.status = ServoStatus::kNotConverged;
  result.reason = "the error is 1 mm, too much";
  result.iterations = 3;
  result.seconds = 1.25;
  result.uncertainty_m = 1e-5;
  result.before_own = Eigen::Vector2d(1e-3, 2e-3);
  result.after_judged = Eigen::Vector2d(-1e-5, 3e-5);
  return result;
}

TEST_CASE("A result comes back as it was written, what is not known stays unknown") {
  const test::TemporaryFolder folder;
  const TargetResult back =
      read_results(folder.write("results.csv", results_header() + result_line(sample()))).at(0);
  CHECK(back.id == "a");
  CHECK(back.status == ServoStatus::kNotConverged);
  CHECK(back.reason == "the error is 1 mm, too much");
  CHECK(back.iterations == 3);
  CHECK((*back.before_own - Eigen::Vector2d(1e-3, 2e-3)).norm() < test::kWrittenNanometre);
  CHECK((*back.after_judged - Eigen::Vector2d(-1e-5, 3e-5)).norm() < test::kWrittenNanometre);
  CHECK_FALSE(back.before_judged.has_value());
  CHECK_FALSE(back.vision_raw.has_value());
}

TEST_CASE("What a tracker judged is read under its name and under that of earlier versions") {
  const test::TemporaryFolder folder;
  TargetResult judged = sample();
  judged.sigma_judged_m = 3e-6;
  const std::string header = results_header(), both = result_line(judged);
  CHECK_THAT(header, Contains("after_tracker_mm,after_tracker_dx_mm,after_tracker_dy_mm"));
  const std::string error = ",0.031623,-0.010000,0.030000";
  const std::size_t by_truth = both.find(error), by_tracker = both.rfind(error);
  REQUIRE(by_truth < by_tracker);
  for (const std::size_t left_out : {by_truth, by_tracker}) {
    std::string line = both;
    const TargetResult back =
        read_results(
            folder.write("results.csv", header + line.replace(left_out, error.size(), ",,,")))
            .at(0);
    CHECK(back.judged_by_tracker());
    CHECK((back.after_judged.value() - Eigen::Vector2d(-1e-5, 3e-5)).norm() <
          test::kWrittenNanometre);
  }
  CHECK_THAT(result_line(sample()), Contains(",,,,,,,\n"));  // no tracker, nothing in its columns
}

TEST_CASE("A run that was interrupted before its first target has no results") {
  const test::TemporaryFolder folder;
  CHECK(read_results(folder.write("results.csv", results_header())).empty());
}

TEST_CASE("A result with a status that does not exist is named") {
  const test::TemporaryFolder folder;
  std::string line = result_line(sample());
  line.replace(line.find("not_converged"), 13, "arrived");
  CHECK_THROWS_MATCHES(read_results(folder.write("results.csv", results_header() + line)),
                       InputError, Refused(Cause::kInvalid, "results.csv:3: status"));
}

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
  CHECK_THROWS_MATCHES(read_step_errors(folder.write("bad.csv", steps_header() + "a,one\n")),
                       InputError, Refused(Cause::kInvalid, "bad.csv:3"));
}

}  // namespace
}  // namespace planar
