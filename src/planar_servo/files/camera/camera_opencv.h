#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/files/camera/camera_file.h"

namespace planar {

/// Returns whether OpenCV's cv::FileStorage wrote the text, which begins with a YAML mark of its
/// own then.
bool is_opencv_storage(const std::string& text);

/// Reads a file of cv::FileStorage, whose parts are named as OpenCV's calibration sample names
/// them: image_width, image_height, camera_matrix, distortion_coefficients (4 or 5, 8 of the
/// rational model, 12 or 14 with thin prism and tilt). OpenCV's own reader is not used: it loops
/// and overflows the stack on files made to that end. Throws InputError naming `path` and what is
/// missing or wrong.
CameraRecord read_camera_opencv(const std::filesystem::path& path);

/// Returns the text of cv::FileStorage for a pinhole, plumb_bob, rational_polynomial or opencv_14
/// camera. Throws InputError for other models.
std::string opencv_text(const CameraRecord& record);

}  // namespace planar
