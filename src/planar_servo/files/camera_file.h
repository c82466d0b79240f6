#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

/// Holds what a camera file tells every reader: the camera and the size of its images.
struct CameraRecord {
  CameraModel camera;
  int width_px{0};
  int height_px{0};
};

/// Reads a ROS camera_info file (ours is one, with further keys), a file of cv::FileStorage of
/// OpenCV or, with the extension .xml, one of vpXmlParserCamera of ViSP. Files of other programs
/// are read leniently: unknown keys are ignored. Throws InputError naming every fault.
CameraRecord read_camera(const std::filesystem::path& path);

/// Throws InputError for a file name whose extension is none of .yaml, .xml and .yml, by which
/// write_camera() chooses the file's kind, and where that kind cannot hold a camera of `model`, one
/// of calibration_model_names(). A name without any extension is a .yaml file's.
void require_camera_name(const std::filesystem::path& path, const std::string& model = "");

/// Writes the calibration of the images `inputs` as a ROS camera_info file with the further keys
/// calibrated_model, standard_deviations, rms_px, held_out_rms_px, images, rejected_images and
/// calibrated_region_px (u and v, from and to). With the extension .xml it writes a file of ViSP,
/// which has pinhole and visp cameras only, and with .yml one of OpenCV. Throws InputError when the
/// file's kind cannot hold the model.
void write_camera(const std::filesystem::path& path, const CameraCalibration& calibration,
                  const std::string& program, const std::vector<std::filesystem::path>& inputs);

/// Reads the pixels of boards' points that another program found. Each line holds one point, `u v`
/// with a space or comma between them, view after view. `#` comments and blank lines are skipped.
/// Throws InputError naming FILE:LINE of each other line, and for a file without points.
std::vector<Eigen::Vector2d> read_board_pixels(const std::filesystem::path& path);

}  // namespace planar
