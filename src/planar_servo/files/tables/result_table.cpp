#include "planar_servo/files/tables/result_table.h"

#include <fmt/format.h>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

bool has_its_pose(const CertificateMove& move) {
  if (move.part == CertificatePart::kWorkspace) return move.pose.empty();
  return move.pose.size() == 2 && move.pose[0] == 'P' && move.pose[1] >= '1' && move.pose[1] <= '5';
}

const TableSchema<JudgedMove>& cycle_schema() {
  static const TableSchema<JudgedMove> cycles{
      "cycles",
      [](Columns& columns, JudgedMove& row) {
        columns.text("id", row.move.id);
        columns.choice("part", row.move.part, kCertificateParts);
        columns.text("pose", row.move.pose);
        columns.check(has_its_pose(row.move),
                      {"pose is '" + row.move.pose + "'",
                       "P1 to P5 is needed, and none for a target of the workspace"},
                      "pose");
        columns.text("from", row.move.from);
        columns.whole_number("cycle", row.move.cycle);
        columns.point("x_mm", "y_mm", row.move.p_d, kMillimetre, 6);
        columns.choice("status", row.status, kServoStatuses);
        columns.text("utc", row.utc);
        columns.number("seconds", row.seconds, 1.0, 3);
        columns.optional_point("dx_mm", "dy_mm", row.error, kMillimetre, 6, Column::kRequired);
        columns.optional_number("dphi_deg", row.turn_error, kDegree, 6, Column::kRequired);
        columns.number("judge_sigma_mm", row.judge_sigma, kMillimetre, 6);
        columns.optional_point("landing_dx_mm", "landing_dy_mm", row.landing_own, kMillimetre, 6,
                               Column::kRequired);
        columns.optional_point("own_view_dx_mm", "own_view_dy_mm", row.error_own, kMillimetre, 6,
                               Column::kRequired);
        columns.optional_number("sigma_vision_mm", row.sigma_vision, kMillimetre, 6,
                                Column::kRequired);
        columns.optional_number("stop_below_mm", row.stop_below, kMillimetre, 6, Column::kRequired);
      },
      UnendedRow::kWarned, RowIds::kOwn};
  return cycles;
}

/// Lists the columns of one error: its length and its components. The length is for people; when
/// reading, it follows from the components.
void list_error(Columns& columns, const char* name, std::optional<Eigen::Vector2d>& field,
                Column need = Column::kRequired) {
  const auto column = [&](const char* part) { return fmt::format("{}{}_mm", name, part); };
  std::optional<double> length;
  if (field) length = field->norm();
  columns.optional_number(column(""), length, kMillimetre, 6, need);
  columns.optional_point(column("_dx"), column("_dy"), field, kMillimetre, 6, need);
}

/// Lists what a tracker judged under its own name. For one version the columns of the truth have
/// it, too.
void list_tracker(Columns& columns, TargetResult& result) {
  const auto list = [&](const char* name, auto& field) {
    auto by_tracker = result.judged_by_tracker() ? field : std::nullopt;
    list_error(columns, name, by_tracker, Column::kOptional);
    if (by_tracker) field = by_tracker;
  };
  auto sigma_m = result.sigma_judged_m;
  columns.optional_number("sigma_tracker_mm", sigma_m, kMillimetre, 6);
  if (sigma_m) result.sigma_judged_m = sigma_m;
  list("before_tracker", result.before_judged);
  list("after_tracker", result.after_judged);
}

const TableSchema<TargetResult>& result_schema() {
  static const TableSchema<TargetResult> results{
      "results", [](Columns& columns, TargetResult& result) {
        columns.text("target", result.id);
        columns.point("x_mm", "y_mm", result.p_d, kMillimetre, 6);
        columns.choice("status", result.status, kServoStatuses);
        columns.text("reason", result.reason);
        columns.whole_number("iterations", result.iterations);
        columns.number("seconds", result.seconds, 1.0, 3);
        columns.optional_number("uncertainty_mm", result.uncertainty_m, kMillimetre, 6,
                                Column::kRequired);
        list_error(columns, "before_own_view", result.before_own);
        list_error(columns, "after_own_view", result.after_own);
        list_error(columns, "before_truth", result.before_judged);
        list_error(columns, "after_truth", result.after_judged);
        list_error(columns, "vision_raw", result.vision_raw);
        list_error(columns, "vision_compensated", result.vision_compensated);
        columns.optional_number("sigma_truth_mm", result.sigma_judged_m, kMillimetre, 6);
        columns.text("not_judged", result.not_judged, Column::kOptional);
        columns.optional_point("believed_dx_mm", "believed_dy_mm", result.believed, kMillimetre, 6);
        columns.optional_number("phi_deg", result.phi_d, kDegree, 6);
        std::optional<double> sigma_m;
        if (result.sigma_target_m > 0.0) sigma_m = result.sigma_target_m;
        columns.optional_number("sigma_target_mm", sigma_m, kMillimetre, 6);
        result.sigma_target_m = sigma_m.value_or(0.0);
        list_tracker(columns, result);
      }};
  return results;
}

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
  static const TableSchema<StepRow> steps{"steps", [](Columns& columns, StepRow& row) {
                                            ServoStep& step = row.step;
                                            columns.text("target", row.id);
                                            columns.whole_number("step", step.iteration);
                                            columns.number("t_s", step.measurement.t_s, 1.0, 6);
                                            columns.text("status", step.measurement.word);
                                            list_measured(columns, step);
                                            columns.number("stop_below_mm", step.stop_below_m,
                                                           kMillimetre, 6);
                                            list_joints(columns, step.theta_c);
                                            list_pulses(columns, step.pulses_c);
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

std::string cycles_header(const std::vector<std::string>& remarks) {
  return cycle_schema().header(remarks);
}

std::string cycle_line(const JudgedMove& move) {
  return cycle_schema().line(move);
}

std::vector<JudgedMove> read_cycles(const std::filesystem::path& path) {
  return TableFile<JudgedMove>(path, cycle_schema()).any_rows();
}

std::string results_header(const std::vector<std::string>& remarks) {
  return result_schema().header(remarks);
}

std::string result_line(const TargetResult& result) {
  return result_columns(result).line();
}

Columns result_columns(const TargetResult& result) {
  return result_schema().columns(result);
}

void write_results(const std::filesystem::path& path, const std::string& header,
                   const std::vector<TargetResult>& results) {
  std::string text = header;
  for (const TargetResult& result : results) text += result_line(result);
  write_file(path, text);
}

std::vector<TargetResult> read_results(const std::filesystem::path& path) {
  return TableFile<TargetResult>(path, result_schema()).any_rows();
}

std::string steps_header() {
  return step_schema().header();
}

std::string step_line(const std::string& id, const ServoStep& step) {
  return step_schema().line({id, step});
}

std::vector<StepError> read_step_errors(const std::filesystem::path& path) {
  return TableFile<StepError>(path, step_error_schema()).rows();
}

std::vector<TableForm> result_forms() {
  return {form_of(cycle_schema()), form_of(result_schema()), form_of(step_schema())};
}

}  // namespace planar
