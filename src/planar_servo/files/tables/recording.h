#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/io/csv_table.h"

namespace planar {

/// One row of a recording's frames.csv: an image and the COMMANDED pose of the arm.
struct FrameRow {
  std::string id;
  std::string image;  ///< relative to the recording's folder
  double t_s{0.0};
  std::string plan;
  Joints theta{0.0, 0.0, 0.0};
  Pulses pulses{0, 0, 0};
  cv::Rect region_px;
};

/// One row of a recording's tracker.csv: the reflector's centre in the tracker's frame, metres.
struct TrackerRow {
  std::string id;
  double t_s{0.0};
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};
};

/// RECORDING/frames.csv. Throws InputError naming each bad row, and for a plan that does not exist.
std::vector<FrameRow> read_frames(const std::filesystem::path& recording);

/// RECORDING/tracker.csv, or another program's table of readings.
std::vector<TrackerRow> read_tracker(const std::filesystem::path& path,
                                     const CsvDialect& dialect = {});

// Growing tables: the header first, then a line at a time.
std::string frames_header();
std::string frame_line(const FrameRow& row);
std::string tracker_header();
std::string tracker_line(const TrackerRow& row);

/// The plans that rows of frames.csv and plan.csv may belong to.
const std::vector<std::string>& plan_names();

// The plans of views of the calibration board: held into the view, and laid on the plane.
constexpr char kHeldBoardPlan[] = "grid";
constexpr char kLaidBoardPlan[] = "plane_grid";

/// True of a plan whose rows show the calibration board instead of the lamps.
bool shows_board(const std::string& plan);

/// Adds a fault to the current row unless there is such a plan.
void check_plan(CsvTable& table, const std::string& plan);

}  // namespace planar
