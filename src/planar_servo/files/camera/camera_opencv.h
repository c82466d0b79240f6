#pragma once

#include <string>

#include "planar_servo/files/camera/camera_file.h"

namespace planar {

/// Whether a text is one of OpenCV's cv::FileStorage (they begin with a YAML mark of their own).
bool is_opencv_storage(const std::string& text);

/// The camera in a cv::FileStorage text, as OpenCV's calibration sample names its parts:
/// image_width, image_height, camera_matrix, distortion_coefficients (4 or 5, 8 of the rational
/// model, 12 or 14 with thin prism and tilt). Throws InputError naming `source` and what is missing
/// or wrong.
CameraRecord camera_from_opencv(const std::string& text, const std::string& source);

/// The same text for a pinhole, plumb_bob, rational_polynomial or opencv_14 camera; throws
/// InputError for other models.
std::string opencv_text(const CameraRecord& record);

}  // namespace planar
