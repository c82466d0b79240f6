#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/arm/workspace.h"
#include "planar_servo/cell/device_kinds.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/monument.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_layout.h"

namespace planar {

/// The `camera` block of a cell.
struct CameraSettings {
  const CameraKind* kind{nullptr};
  int width_px{0};  ///< of the whole sensor
  int height_px{0};
  double frame_rate_hz{0.0};
  double timeout_s{0.0};    ///< the longest wait for a frame
  int follow_region_px{0};  ///< side of the region of the sensor that follows the lamps
  std::shared_ptr<const DeviceDetails> details;  ///< what only this kind has
};

/// What an item of `drives` says beyond the motor itself, which TransmissionSettings has.
struct DriveSettings {
  const DriveKind* kind{nullptr};
  std::shared_ptr<const DeviceDetails> details;
};

/// The `lamps` block of a cell.
struct LampSettings {
  LampLayout layout;
  CenterMethod method{CenterMethod::kAuto};
};

/// The `arm` block of a cell, but for the transmission.
struct ArmSettings {
  ArmGeometry geometry;
  Elbow elbow{Elbow::kLeft};
  Joints home{0.0, 0.0, 0.0};
};

/// The `tracker` block of a cell.
struct TrackerSettings {
  const TrackerKind* kind{nullptr};
  double sigma_m{0.0};        ///< standard deviation per axis of a reading, at no distance
  double sigma_m_per_m{0.0};  ///< by how much it grows with the distance

  /// Standard deviation per axis of a reading at this distance from the tracker, metres.
  double sigma_at(double range_m) const { return sigma_m + sigma_m_per_m * range_m; }
};

/// Everything that is known of a cell before it is calibrated, in SI. A cell file holds it.
struct CellSettings {
  std::filesystem::path file;  ///< where it was read
  CameraSettings camera;
  std::filesystem::path camera_model, workplane, tool, error_map;  ///< may not exist yet
  LampSettings lamps;
  ArmSettings arm;
  TransmissionSettings transmission;
  std::array<DriveSettings, 3> drives;
  double tool_orientation{0.0};  ///< radians
  ServoSettings servo;
  TrackerSettings tracker;
  std::vector<Monument> datum;
  Workspace workspace;
  std::optional<std::filesystem::path> truth;  ///< of a virtual cell
};

/// Plans the moves of the cell's arm within its limits and workspace, with its elbow.
JointPlanner joint_planner(const CellSettings& cell);

}  // namespace planar
