#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/io/columns.h"

namespace planar {

/// Visits the columns theta1_deg, theta2_deg and theta3_deg, which a table may lack and a row may
/// leave empty. A row that has only some of them is at fault.
void list_joints(Columns& columns, std::optional<Joints>& theta);

/// Holds a row of samples.csv: commanded joints and where a point of the tool was measured, base
/// frame.
struct ArmSampleRow {
  std::string id;
  Joints theta{0.0, 0.0, 0.0};    ///< radians
  Eigen::Vector2d p_B{0.0, 0.0};  ///< metres
  double sigma{0.0};              ///< per axis, metres
};

/// Reads samples.csv. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<ArmSampleRow> read_arm_samples(const std::filesystem::path& path);

}  // namespace planar
