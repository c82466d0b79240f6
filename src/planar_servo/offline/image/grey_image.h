#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string_view>

namespace planar {

/// Reads a picture as 8-bit grey levels. Returns an empty image when the file is absent, no picture
/// or not a whole one. Throws InputError for a file that may not be read.
cv::Mat read_grey_image(const std::filesystem::path& file);

/// Returns whether the bytes of a PNG, PGM or JPEG file reach to its end; true for other formats.
/// OpenCV's readers print what they find cut short, and take half a JPEG for a picture.
bool is_whole_picture(std::string_view bytes);

}  // namespace planar
