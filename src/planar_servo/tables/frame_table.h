#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/plan.h"

namespace planar {

/// Holds one row of a recording's frames.csv: an image and the COMMANDED pose of the arm.
struct FrameRow {
  std::string id;
  std::string image;  ///< relative to the recording's folder
  double t_s{0.0};
  Plan plan{Plan::kTrain};
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

}  // namespace planar
