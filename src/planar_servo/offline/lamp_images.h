#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {

/// Describes an image in which lamps are to be located.
struct LampImage {
  std::string id;
  std::string name;  ///< the image's name in tables
  std::filesystem::path file;
  std::optional<double> t_s;
  std::optional<cv::Rect> region_px;        ///< its place on the sensor; empty: at the origin
  std::optional<TipPose> commanded;         ///< commanded pose, base frame
  bool shows_board{false};                  ///< shows a calibration board instead of the lamps
  std::shared_ptr<const PictureSet> set{};  ///< to which it belongs
};

/// Lists the images of a recording. They have their commanded poses when the arm is given.
std::vector<LampImage> images_of_recording(const std::filesystem::path& folder,
                                           const std::vector<FrameRow>& frames,
                                           const std::optional<PlanarArm>& arm);

/// Lists images of which nothing else is known. The id of each is its file's stem.
std::vector<LampImage> single_images(const std::vector<std::filesystem::path>& files);

/// Holds an image that was read, or says why it was not.
struct LampImageRead {
  LampStatus status{LampStatus::kOk};  ///< or kBoardView, kUnreadable, kWrongSize
  Frame frame;                         ///< valid only when status is kOk
  std::string fault;                   ///< describes a wrong size in words
};

/// Reads an image as 8-bit grey levels. It must have the size of its region or, without one, that
/// of the sensor if that is known.
LampImageRead read_lamp_image(const LampImage& image, const std::optional<cv::Size>& sensor_px);

}  // namespace planar
