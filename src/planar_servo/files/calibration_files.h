#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/health/health_record.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// Reads the cell's camera, workplane, tool and, when asked for, error map. Throws InputError
/// naming every file that is missing with the program that makes it, for a camera file of another
/// image size than the cell's, and for a workplane that was made before the cell had its reference
/// lamps.
VisionCalibration read_vision(const CellSettings& cell, bool with_error_map);

/// Reads as much of the cell's vision as there are files for. The error map is left out.
LampScene read_lamp_scene(const CellSettings& cell);

/// Reads the cell's camera. Throws InputError when it was calibrated for images of another size
/// than the cell's.
CameraModel read_cell_camera(const CellSettings& cell);

/// Throws InputError when the cell has reference lamps and its workplane knows none.
void require_reference_lamps(const CellSettings& cell, const std::vector<ReferenceLamp>& known);

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
