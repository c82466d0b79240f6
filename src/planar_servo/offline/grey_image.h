#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Pictures of one camera, read as 8-bit grey levels by one scale: that of the bits that those with
/// 16 bits use together, whether they stand high or low in them. A picture's pixels are those of
/// the sensor: no tag turns them.
class PictureSet {
 public:
  /// Looks at all pictures, and says which bits are used and which pictures have a tag of a turn.
  /// Throws InputError for a file that may not be read.
  explicit PictureSet(const std::vector<std::filesystem::path>& files);

  /// Returns an empty image when the file is absent, no picture, not a whole one, larger than any
  /// sensor or none of grey levels; what a user would not guess of these is logged.
  cv::Mat read(const std::filesystem::path& file) const;

 private:
  double level_{1.0};  ///< of 8 bits in those of 16
};

/// Reads a picture that belongs to no set.
cv::Mat read_grey_image(const std::filesystem::path& file);

/// Returns the EXIF orientation of a JPEG, PNG or TIFF file from its first bytes; 1 where it has
/// none.
int orientation_tag(std::string_view bytes);

/// Returns whether the bytes of a PNG, PGM or JPEG file reach to its end; true for other formats.
/// OpenCV's readers print what they find cut short, and take half a JPEG for a picture.
bool is_whole_picture(std::string_view bytes);

/// Width and height in pixels.
struct PictureSize {
  std::size_t width{0}, height{0};
};

/// Returns the size that the header of a PNG, PGM or JPEG file states; empty for other formats.
std::optional<PictureSize> stated_size(std::string_view bytes);

/// Returns a whole picture of the cell's camera as a frame. Throws InputError naming `where` for
/// one of another size.
Frame whole_frame(const cv::Mat& image, const CellSettings& cell, const std::string& where);

/// Reads saved pictures as frames of the camera. Throws InputError for one of another size.
std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell);

}  // namespace planar
