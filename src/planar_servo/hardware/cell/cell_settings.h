#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/cell/device_kinds.h"
#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Names the control law that turns a measured error into a joint step; see servo/position_servo.h.
enum class ServoLaw { kJacobian, kInverse };

/// Says how the last motion of a step arrives: straight, or always from the same side of every
/// motor, so that play in the gears does not show.
enum class Approach { kDirect, kOneSide };

/// Holds the `servo` block of a cell, in SI units.
struct ServoSettings {
  ServoLaw law{ServoLaw::kJacobian};
  double gain{1.0};  ///< in (0, 1]
  double tolerance_m{5e-6};
  double orientation_tolerance{0.2 * kDegree};  ///< of the tool's direction, radians
  int max_iterations{12};  ///< corrections after the first move; with 0 it only measures
  double max_step_m{5e-3};
  double settle_s{0.2};
  int frames_per_measurement{3};
  bool learns{true};  ///< the arm, from looks at its targets, where it was found with its field
  Approach approach{Approach::kOneSide};
  /// The angle by which every motor, behind its gear, first stops short when it approaches from one
  /// side. It must exceed the play; 0.2 deg is several times that of a gear fit for positioning.
  double approach_margin_rad{0.2 * kDegree};
};

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

  /// Returns the standard deviation per axis of a reading this far from the tracker, metres.
  double sigma_at(double range_m) const { return sigma_m + sigma_m_per_m * range_m; }
};

/// Holds what is known of a cell before it is calibrated, in SI units: the contents of a cell file.
struct CellSettings {
  std::filesystem::path file;  ///< the cell file from which this was read
  CameraSettings camera;
  /// The files of the calibration, which may not exist yet.
  std::filesystem::path camera_model, workplane, tool, error_map;
  std::optional<std::filesystem::path> health;       ///< what the calibration kept for later checks
  std::optional<std::filesystem::path> arm_found;    ///< the arm as its poses showed it
  std::optional<std::filesystem::path> arm_learned;  ///< what looks have taught of it since
  std::map<std::string, std::filesystem::path> tools;  ///< files of taught tips, by name
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

/// Returns the settings that only the kind of this part of the cell has.
template <typename Details, typename Part>
const Details& details_of(const Part& part) {
  return static_cast<const Details&>(*part.details);
}

/// Returns a planner of moves within limits and workspace of the cell's arm, with its elbow.
inline JointPlanner joint_planner(const CellSettings& cell) {
  return {PlanarArm(cell.arm.geometry), Transmission(cell.transmission), cell.workspace,
          cell.arm.elbow,
          cell.servo.approach == Approach::kOneSide ? cell.servo.approach_margin_rad : 0.0};
}

}  // namespace planar
