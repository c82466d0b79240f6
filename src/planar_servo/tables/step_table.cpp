#include "planar_servo/tables/step_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

struct StepRow {
  std::string id;
  ServoStep step;
};

/// Lists the columns that only a measured step fills. They are only written.
void list_measured(Columns& columns, const ServoStep& step) {
  const TipMeasurement& m = step.measurement;
  const auto number = [&](const char* column, double value, double unit, int decimals) {
    std::optional<double> field;
    if (m.ok()) field = value;
    columns.optional_number(column, field, unit, decimals, Column::kRequired);
  };
  const auto point = [&](const char* x, const char* y, const Eigen::Vector2d& p, double unit,
                         int decimals) {
    number(x, p.x(), unit, decimals);
    number(y, p.y(), unit, decimals);
  };
  point("u1_px", "v1_px", m.lamps_px[0], 1.0, 4);
  point("u2_px", "v2_px", m.lamps_px[1], 1.0, 4);
  point("x_vision_mm", "y_vision_mm", m.p_vision, kMillimetre, 6);
  number("phi_deg", m.tip.phi, kDegree, 6);
  point("dx_map_mm", "dy_map_mm", m.correction, kMillimetre, 6);
  point("x_mm", "y_mm", m.tip.p, kMillimetre, 6);
  number("uncertainty_mm", step.uncertainty_m(), kMillimetre, 6);
  point("dx_mm", "dy_mm", step.error, kMillimetre, 6);
  number("error_mm", step.error.norm(), kMillimetre, 6);
  point("x_believed_mm", "y_believed_mm", step.believed_p(), kMillimetre, 6);
  number("miss_mm", step.miss_m(), kMillimetre, 6);
}

const TableSchema<StepRow>& step_schema() {
  static const TableSchema<StepRow> steps{
      "steps", [](Columns& columns, StepRow& row) {
        ServoStep& step = row.step;
        columns.text("target", row.id);
        columns.whole_number("step", step.iteration);
        columns.number("t_s", step.measurement.t_s, 1.0, 6);
        columns.text("status", step.measurement.word);
        list_measured(columns, step);
        columns.number("stop_below_mm", step.stop_below_m, kMillimetre, 6);
        columns.number("theta1_deg", step.theta_c[0], kDegree, 9);
        columns.number("theta2_deg", step.theta_c[1], kDegree, 9);
        columns.number("theta3_deg", step.theta_c[2], kDegree, 9);
        columns.whole_number("m1_pulses", step.pulses_c[0]);
        columns.whole_number("m2_pulses", step.pulses_c[1]);
        columns.whole_number("m3_pulses", step.pulses_c[2]);
      }};
  return steps;
}

/// Lists the columns that are read back.
const TableSchema<StepError>& step_error_schema() {
  static const TableSchema<StepError> errors{
      "steps", [](Columns& columns, StepError& row) {
        columns.text("target", row.target);
        columns.whole_number("step", row.step);
        columns.optional_number("error_mm", row.error, kMillimetre, 6, Column::kRequired);
      }};
  return errors;
}

}  // namespace

std::string steps_header() {
  return step_schema().header();
}

std::string step_line(const std::string& id, const ServoStep& step) {
  return step_schema().line({id, step});
}

std::vector<StepError> read_step_errors(const std::filesystem::path& path) {
  return TableFile<StepError>(path, step_error_schema()).rows();
}

}  // namespace planar
