#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/purpose.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

class Columns;

/// Holds a row of plan.csv: one position to be recorded, by tip pose or by joints. Rows of the
/// plans "grid" and "plane_grid" ask for a view of the calibration board and need neither. Lengths
/// are in metres, angles in radians.
struct PlanRow {
  std::string id;
  Purpose plan{Purpose::kTrain};
  std::variant<std::monostate, TipPose, Joints> where;
};

/// Reads plan.csv. Rows by x and y that name no phi_deg take `tool_orientation` (radians). Throws
/// InputError naming FILE:LINE of each bad row, and for a table without rows.
std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation);
std::string plan_text(const std::vector<PlanRow>& rows);

/// Holds one row of a recording's frames.csv: an image and the COMMANDED pose of the arm.
struct FrameRow {
  std::string id;
  std::string image;  ///< relative to the recording's folder
  double t_s{0.0};
  Purpose plan{Purpose::kTrain};
  Joints theta{0.0, 0.0, 0.0};
  Pulses pulses{0, 0, 0};
  cv::Rect region_px;
};

/// Reads RECORDING/frames.csv. Throws InputError for a missing file, for a table without rows and,
/// naming FILE:LINE of each, for bad rows such as those with an unknown plan.
std::vector<FrameRow> read_frames(const std::filesystem::path& recording);

// The table grows: the header first, then a line at a time.
std::string frames_header();
std::string frame_line(const FrameRow& row);

// Columns that other tables have, too.

/// Visits the columns theta1_deg, theta2_deg and theta3_deg.
void list_joints(Columns& columns, Joints& theta);
/// Visits the same in a table that may lack them and whose rows may leave them empty. A row that
/// has only some of them is at fault.
void list_joints(Columns& columns, std::optional<Joints>& theta);
/// Visits the columns m1_pulses, m2_pulses and m3_pulses.
void list_pulses(Columns& columns, Pulses& pulses);

}  // namespace planar
