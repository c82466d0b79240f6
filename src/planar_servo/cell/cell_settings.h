#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/arm/workspace.h"
#include "planar_servo/cell/device_kinds.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Holds the `camera` block of a cell.
struct CameraSettings {
  const CameraKind* kind{nullptr};
  int width_px{0};   ///< width of the whole sensor
  int height_px{0};  ///< height of the whole sensor
  double frame_rate_hz{0.0};
  double timeout_s{0.0};                ///< the longest wait for a frame
  int follow_region_px{0};              ///< side of the region of the sensor that follows the lamps
  std::optional<double> pixel_pitch_m;  ///< from the data sheet; only the doctor uses it
  std::shared_ptr<const DeviceDetails> details;  ///< the settings that only this kind has
};

/// Holds an item of `drives` without the motor itself, which TransmissionSettings has.
struct DriveSettings {
  const DriveKind* kind{nullptr};
  std::shared_ptr<const DeviceDetails> details;
};

/// Holds the `lamps` block of a cell.
struct LampSettings {
  LampLayout layout;
  CenterMethod method{CenterMethod::kAuto};
};

/// Holds the `arm` block of a cell without the transmission.
struct ArmSettings {
  ArmGeometry geometry;
  Elbow elbow{Elbow::kLeft};
  Joints home{0.0, 0.0, 0.0};
};

/// Holds the `tracker` block of a cell. The standard deviation of a reading grows with the distance
/// from the tracker.
struct TrackerSettings {
  const TrackerKind* kind{nullptr};
  double sigma_m{0.0};        ///< standard deviation per axis at the tracker itself
  double sigma_m_per_m{0.0};  ///< growth of it per metre of distance
  /// By how much its systematic error differs over the field, standard deviation per axis.
  std::optional<double> bias_m;
  std::shared_ptr<const DeviceDetails> details;  ///< the settings that only this kind has

  /// Returns the standard deviation per axis of a reading at this distance from the tracker,
  /// metres.
  double sigma_at(double range_m) const { return sigma_m + sigma_m_per_m * range_m; }
};

/// Holds everything that is known of a cell before it is calibrated, in SI units: the contents of a
/// cell file.
struct CellSettings {
  std::filesystem::path file;  ///< the cell file from which this was read
  CameraSettings camera;
  /// The files of the calibration, which may not exist yet.
  std::filesystem::path camera_model, workplane, tool, error_map;
  std::optional<std::filesystem::path> health;       ///< what the calibration kept for later checks
  std::optional<std::filesystem::path> arm_found;    ///< the arm as its poses showed it
  std::optional<std::filesystem::path> arm_learned;  ///< what looks have taught of it since
  LampSettings lamps;
  std::vector<ReferenceLampLayout> reference_lamps;
  ArmSettings arm;
  TransmissionSettings transmission;
  std::array<DriveSettings, 3> drives;
  double tool_orientation{0.0};  ///< radians
  ServoSettings servo;
  TrackerSettings tracker;
  std::vector<Monument> datum;
  Workspace workspace;
  std::optional<std::filesystem::path> truth;  ///< the truth file of a virtual cell
};

/// Returns a planner of moves within the limits and the workspace of the cell's arm, with its
/// elbow.
JointPlanner joint_planner(const CellSettings& cell);

}  // namespace planar
