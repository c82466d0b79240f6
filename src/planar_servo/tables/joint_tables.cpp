#include "planar_servo/tables/joint_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "planar_servo/core/units.h"

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

void list_joints(Columns& columns, std::optional<Joints>& theta) {
  constexpr std::array<const char*, 3> kNames{"theta1_deg", "theta2_deg", "theta3_deg"};
  std::array<std::optional<double>, 3> angles;
  for (std::size_t j = 0; j < angles.size(); ++j) {
    if (theta) angles[j] = (*theta)[static_cast<Eigen::Index>(j)];
    columns.optional_number(kNames[j], angles[j], kDegree, 6, Column::kOptional);
  }
  if (!columns.reading()) return;
  theta.reset();
  const auto is_given = [](const std::optional<double>& angle) { return angle.has_value(); };
  if (std::none_of(angles.begin(), angles.end(), is_given)) return;
  for (std::size_t j = 0; j < angles.size(); ++j)
    columns.check(is_given(angles[j]),
                  {fmt::format("{} is ''", kNames[j]), "a finite number is needed"});
  theta = Joints(angles[0].value_or(0.0), angles[1].value_or(0.0), angles[2].value_or(0.0));
}

std::vector<ArmSampleRow> read_arm_samples(const std::filesystem::path& path) {
  return TableFile<ArmSampleRow>(path, arm_sample_schema()).rows();
}

}  // namespace planar
