#include "planar_servo/files/tables/step_table.h"

#include <algorithm>
#include <catch2/catch.hpp>

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

}  // namespace
}  // namespace planar
