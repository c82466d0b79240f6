#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

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
