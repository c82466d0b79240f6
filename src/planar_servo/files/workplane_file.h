#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/core/pose.h"

namespace planar {

/// workplane.yaml: the camera over the plane of the lamps, and how that was found.
struct WorkplaneRecord {
  Pose X_WC{Pose::Identity()};
  /// Of (translation, rotation vector in W), m and rad; mm and rad in the file.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
  std::string source{"pairs"};  ///< "pairs", or "grid": height and tilt from a board on the plane
  int absorbed{6};              ///< degrees of freedom fitted to the pairs
  int pairs{0};                 ///< places used
  double rms{0.0};              ///< of the distances from vision to tracker there, metres
};

std::string workplane_text(const WorkplaneRecord& record, const std::string& program,
                           const std::vector<std::filesystem::path>& inputs);

/// Throws InputError naming every fault; a camera must look down from above the plane.
WorkplaneRecord read_workplane(const std::filesystem::path& path);

}  // namespace planar
