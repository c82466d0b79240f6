#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/health/health_record.h"
#include "planar_servo/tool/tool_offsets.h"
#include "planar_servo/vision/reference_lamps.h"

namespace planar {

/// Says what determines the camera's pose: the pairs alone, or the pairs and a board laid on the
/// plane, which determines the camera's height and tilt.
enum class WorkplaneSource { kPairs, kBoard };

/// The words that files and options have for the sources.
constexpr Named<WorkplaneSource> kWorkplaneSources[] = {{WorkplaneSource::kPairs, "pairs"},
                                                        {WorkplaneSource::kBoard, "grid"}};

/// Holds workplane.yaml: the pose of the camera over the plane of the lamps, and how it was found.
struct WorkplaneRecord {
  Pose X_WC{Pose::Identity()};
  /// The covariance of (translation, rotation vector in W), in m and rad; in mm and rad in the
  /// file.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
  WorkplaneSource source{WorkplaneSource::kPairs};
  int absorbed{6};  ///< degrees of freedom fitted to the pairs
  int pairs{0};     ///< places used
  double rms{0.0};  ///< of the distances from vision to tracker there, metres
  /// Where the lamps that are fixed to the base were seen when X_WC held; none without any.
  std::vector<ReferenceLamp> reference_lamps{};
};

// Files of a calibration: each has a text by `program`, made from `origins`, and a reader that
// throws InputError naming every fault with its place.

/// The camera must look down from above the plane.
std::string workplane_text(const WorkplaneRecord& record, const std::string& program,
                           const std::vector<Origin>& origins);
WorkplaneRecord read_workplane(const std::filesystem::path& path);

/// Lengths are in mm and the covariance in mm^2.
std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<Origin>& origins);
ToolOffsets read_tool(const std::filesystem::path& path);

std::string health_text(const HealthRecord& record, const std::string& program,
                        const std::vector<Origin>& origins);
HealthRecord read_health(const std::filesystem::path& path);

}  // namespace planar
