#include "planar_servo/tables/cycle_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"
#include "planar_servo/tables/table_columns.h"

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

TableForm cycle_form() {
  return form_of(cycle_schema());
}

}  // namespace planar
