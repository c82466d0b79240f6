#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/devices/frame.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/plans.h"

namespace planar {

/// An image in which lamps are to be located, and what is known of it.
struct LampImage {
  std::string id;
  std::string name;  ///< as tables have it
  std::filesystem::path file;
  std::optional<double> t_s;
  std::optional<cv::Rect> region_px;  ///< where it lies on the sensor; none: at its origin
  std::optional<TipPose> commanded;   ///< base frame
  bool shows_board{false};            ///< a calibration board instead of the lamps
};

/// The images of a recording; their commanded poses when the arm is known.
std::vector<LampImage> images_of_recording(const std::filesystem::path& folder,
                                           const std::vector<FrameRow>& frames,
                                           const std::optional<PlanarArm>& arm);

/// Images of which nothing else is known; the id is the file's stem.
std::vector<LampImage> single_images(const std::vector<std::filesystem::path>& files);

struct LampImageRead {
  std::string status{"ok"};  ///< or "board_view", "unreadable", "wrong_size"
  Frame frame;               ///< valid only when status is "ok"
  std::string fault;         ///< of a wrong size: in words
};

/// Reads the image as 8-bit grey levels. It must have the size of its region, or without one that
/// of the sensor, if that is known.
LampImageRead read_lamp_image(const LampImage& image, const std::optional<cv::Size>& sensor_px);

}  // namespace planar
