#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/arm/workspace.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/servo/servo_settings.h"

namespace planar {

/// What only a camera of source aravis has.
struct CameraConnection {
  std::string address;  ///< of a GigE camera; empty: USB
  std::string id;       ///< serial number; empty: any
  double exposure_s{0.0};
  double gain_db{0.0};
  std::string pixel_format;
  std::string trigger;  ///< "free_run", "software" or "hardware"
  int packet_size{0};   ///< bytes; 0: the largest that passes
};

struct CameraSettings {
  std::string source;  ///< "virtual", "files" or "aravis"
  int width_px{0};
  int height_px{0};
  double pixel_pitch_m{0.0};
  double frame_rate_hz{0.0};
  double timeout_s{0.0};
  int follow_region_px{0};
  double gain_e_per_level{0.0};
  CameraConnection connection;
};

struct DriveSettings {
  std::string kind;               ///< "virtual" or "tic"
  std::string serial;             ///< of a tic
  double command_timeout_s{0.0};  ///< of a tic
};

struct ArmSettings {
  ArmGeometry geometry;
  Elbow elbow{Elbow::kLeft};
  Joints home{0.0, 0.0, 0.0};
};

/// cell.yaml: everything that is known of a cell before it is calibrated, in SI.
struct CellSettings {
  std::filesystem::path file;
  CameraSettings camera;
  std::filesystem::path camera_model, workplane, tool, error_map;  ///< may not exist yet
  std::array<double, 2> lamp_diameters_m{0.0, 0.0};
  double lamp_separation_m{0.0};
  ArmSettings arm;
  TransmissionSettings transmission;
  std::array<DriveSettings, 3> drives;
  double tool_orientation{0.0};  ///< radians
  ServoSettings servo;
  double tracker_sigma_m{0.0};
  double tracker_sigma_m_per_m{0.0};
  std::vector<Monument> datum;
  Workspace workspace;
  std::optional<std::filesystem::path> truth;  ///< of a virtual cell

  /// Standard deviation per axis of a tracker reading at this range, metres.
  double tracker_sigma_at(double range_m) const;
};

/// Reads a cell file strictly: throws InputError naming every fault with FILE:LINE:COLUMN.
CellSettings read_cell(const std::filesystem::path& path);

/// `path` when it exists, else InputError naming `program`, which makes that file.
const std::filesystem::path& require_made(const std::filesystem::path& path,
                                          const std::string& program);

}  // namespace planar
