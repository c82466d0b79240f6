#include "planar_servo/files/tables/servo_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/csv_table.h"

namespace planar {
namespace {

constexpr ServoStatus kStatuses[] = {ServoStatus::kReached,      ServoStatus::kOutsideMap,
                                     ServoStatus::kNotConverged, ServoStatus::kDiverged,
                                     ServoStatus::kLostLamp,     ServoStatus::kLostCamera,
                                     ServoStatus::kRefused};

std::string in_mm(const Eigen::Vector2d& p) {
  return fixed(p / kMillimetre, 6, ",");
}

std::string error_fields(const std::optional<Eigen::Vector2d>& error) {
  if (!error) return ",,";
  return fmt::format("{:.6f},{}", error->norm() / kMillimetre, in_mm(*error));
}

ServoStatus status_at(CsvTable& table) {
  for (const ServoStatus status : kStatuses)
    if (table.text("status") == name(status)) return status;
  table.add_fault(fmt::format("status is '{}', which no target can have", table.text("status")));
  return ServoStatus::kRefused;
}

std::optional<Eigen::Vector2d> error_at(CsvTable& table, const ResultError& error) {
  const auto columns = error.columns();
  if (table.text(columns[1]).empty()) return std::nullopt;
  return Eigen::Vector2d(table.number(columns[1]), table.number(columns[2])) * kMillimetre;
}

std::vector<std::string> result_columns() {
  std::vector<std::string> columns{"target", "x_mm",       "y_mm",    "status",
                                   "reason", "iterations", "seconds", "uncertainty_mm"};
  for (const ResultError& error : result_errors())
    for (const std::string& column : error.columns()) columns.push_back(column);
  return columns;
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
  return CsvWriter("results", result_columns()).text();
}

std::string result_line(const TargetResult& result) {
  std::string reason = result.reason;
  std::replace(reason.begin(), reason.end(), ',', ';');
  std::string line = fmt::format("{},{},{},{},{},{:.3f},", result.id, in_mm(result.p_d),
                                 name(result.status), reason, result.iterations, result.seconds);
  if (result.uncertainty_m) line += fmt::format("{:.6f}", *result.uncertainty_m / kMillimetre);
  for (const ResultError& error : result_errors()) line += ',' + error_fields(result.*error.error);
  return line + '\n';
}

std::vector<TargetResult> read_results(const std::filesystem::path& path) {
  CsvFile table(path, "results", result_columns());
  std::vector<TargetResult> results;
  while (table.next_row()) {
    TargetResult result;
    result.id = table.text("target");
    result.p_d = Eigen::Vector2d(table.number("x_mm"), table.number("y_mm")) * kMillimetre;
    result.status = status_at(table);
    result.reason = table.text("reason");
    result.iterations = table.whole_number("iterations");
    result.seconds = table.number("seconds");
    if (const auto uncertainty_mm = table.optional_number("uncertainty_mm"))
      result.uncertainty_m = *uncertainty_mm * kMillimetre;
    for (const ResultError& error : result_errors()) result.*error.error = error_at(table, error);
    results.push_back(std::move(result));
  }
  table.throw_if_faulty();
  return results;
}

std::string steps_header() {
  return CsvWriter("steps",
                   {"target",         "step",       "t_s",        "status",      "u1_px",
                    "v1_px",          "u2_px",      "v2_px",      "x_vision_mm", "y_vision_mm",
                    "phi_deg",        "dx_map_mm",  "dy_map_mm",  "x_mm",        "y_mm",
                    "uncertainty_mm", "dx_mm",      "dy_mm",      "error_mm",    "stop_below_mm",
                    "theta1_deg",     "theta2_deg", "theta3_deg", "m1_pulses",   "m2_pulses",
                    "m3_pulses"})
      .text();
}

std::string step_line(const std::string& id, const ServoStep& step) {
  const TipMeasurement& m = step.measurement;
  std::string seen = ",,,,,,,,,,,,,,";
  if (m.ok())
    seen =
        fmt::format("{},{},{},{},{},{},{:.6f},{},{:.6f}", fixed(m.lamps_px[0], 4, ","),
                    fixed(m.lamps_px[1], 4, ","), in_mm(m.p_vision), fixed(m.tip.phi / kDegree, 6),
                    in_mm(m.correction), in_mm(m.tip.p), m.uncertainty_m / kMillimetre,
                    in_mm(step.error), step.error.norm() / kMillimetre);
  return fmt::format("{},{},{:.6f},{},{},{:.6f},{},{},{},{}\n", id, step.iteration, m.t_s, m.word,
                     seen, step.stop_below_m / kMillimetre, fixed(step.theta_c / kDegree, 9, ","),
                     step.pulses_c[0], step.pulses_c[1], step.pulses_c[2]);
}

}  // namespace planar
