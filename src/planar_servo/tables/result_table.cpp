#include "planar_servo/tables/result_table.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

/// Lists the columns of one error. Its length is for people; when reading, it follows from the
/// components.
void list_error(Columns& columns, const char* name, std::optional<Eigen::Vector2d>& field,
                Column need) {
  const auto [length_mm, dx_mm, dy_mm] = ResultError{name, nullptr}.columns();
  std::optional<double> length;
  if (field) length = field->norm();
  columns.optional_number(length_mm, length, kMillimetre, 6, need);
  columns.optional_point(dx_mm, dy_mm, field, kMillimetre, 6, need);
}

/// Lists what a tracker judged under its own name. For one version the columns of the truth have
/// it, too.
void list_tracker(Columns& columns, TargetResult& result) {
  const auto list = [&](const char* name, auto& field) {
    auto by_tracker = result.judged_by_tracker() ? field : std::nullopt;
    list_error(columns, name, by_tracker, Column::kOptional);
    if (by_tracker) field = by_tracker;
  };
  auto sigma_m = result.sigma_truth_m;
  columns.optional_number("sigma_tracker_mm", sigma_m, kMillimetre, 6, Column::kOptional);
  if (sigma_m) result.sigma_truth_m = sigma_m;
  list("before_tracker", result.before_truth);
  list("after_tracker", result.after_truth);
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
        for (const ResultError& error : result_errors())
          list_error(columns, error.name, result.*error.error, Column::kRequired);
        columns.optional_number("sigma_truth_mm", result.sigma_truth_m, kMillimetre, 6,
                                Column::kOptional);
        columns.text("not_judged", result.not_judged, Column::kOptional);
        columns.optional_point("believed_dx_mm", "believed_dy_mm", result.believed, kMillimetre, 6,
                               Column::kOptional);
        columns.optional_number("phi_deg", result.phi_d, kDegree, 6, Column::kOptional);
        list_tracker(columns, result);
      }};
  return results;
}

}  // namespace

std::array<std::string, 3> ResultError::columns() const {
  return {fmt::format("{}_mm", name), fmt::format("{}_dx_mm", name), fmt::format("{}_dy_mm", name)};
}

const std::vector<ResultError>& result_errors() {
  static const std::vector<ResultError> errors{
      {"before_own_view", &TargetResult::before_own},
      {"after_own_view", &TargetResult::after_own},
      {"before_truth", &TargetResult::before_truth},
      {"after_truth", &TargetResult::after_truth},
      {"vision_raw", &TargetResult::vision_raw},
      {"vision_compensated", &TargetResult::vision_compensated}};
  return errors;
}

std::string results_header() {
  return results_header({});
}

std::string results_header(const std::vector<std::string>& remarks) {
  return result_schema().header(remarks);
}

std::string result_line(const TargetResult& result) {
  return result_schema().line(result);
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

}  // namespace planar
