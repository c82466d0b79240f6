#include "planar_servo/files/tables/arm_sample_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

const TableSchema<ArmSampleRow>& arm_sample_schema() {
  static const TableSchema<ArmSampleRow> samples{
      "samples", [](Columns& columns, ArmSampleRow& row) {
        columns.text("id", row.id);
        columns.number("theta1_deg", row.theta[0], kDegree, 6);
        columns.number("theta2_deg", row.theta[1], kDegree, 6);
        columns.number("theta3_deg", row.theta[2], kDegree, 6);
        columns.point("x_mm", "y_mm", row.p_B, kMillimetre, 6);
        columns.number("sigma_mm", row.sigma, kMillimetre, 6);
      }};
  return samples;
}

}  // namespace

std::vector<ArmSampleRow> read_arm_samples(const std::filesystem::path& path) {
  TableFile<ArmSampleRow> table(path, arm_sample_schema());
  std::vector<ArmSampleRow> rows;
  for (ArmSampleRow row; table.next(row);) rows.push_back(row);
  table.throw_if_faulty_or_empty();
  return rows;
}

}  // namespace planar
