#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace planar {

/// Reads a picture as 8-bit grey levels. Returns an empty image when the file is absent, no
/// picture, not a whole one or larger than any sensor. Throws InputError for a file that may not be
/// read.
cv::Mat read_grey_image(const std::filesystem::path& file);

/// Returns whether the bytes of a PNG, PGM or JPEG file reach to its end; true for other formats.
/// OpenCV's readers print what they find cut short, and take half a JPEG for a picture.
bool is_whole_picture(std::string_view bytes);

/// Width and height in pixels.
struct PictureSize {
  std::size_t width{0}, height{0};
};

/// Returns the size that the header of a PNG, PGM or JPEG file states; empty for other formats.
std::optional<PictureSize> stated_size(std::string_view bytes);

}  // namespace planar
