#include "planar_servo/offline/saved_frames.h"

#include <fmt/format.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {

Frame whole_frame(const cv::Mat& image, const CellSettings& cell, const std::string& where) {
  const cv::Size sensor_px(cell.camera.width_px, cell.camera.height_px);
  if (image.size() != sensor_px)
    throw InputError({fmt::format("is {} x {} px, the cell's sensor {} x {}", image.cols,
                                  image.rows, sensor_px.width, sensor_px.height),
                      "give whole pictures of the cell's camera", where});
  return {image, {{}, sensor_px}};
}

std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell) {
  const PictureSet pictures(images);
  std::vector<Frame> frames;
  for (const std::filesystem::path& image : images) {
    const cv::Mat picture = pictures.read(image);
    if (picture.empty()) throw InputError({"is no picture that can be read", "", image});
    frames.push_back(whole_frame(picture, cell, image));
    frames.back().id = frames.size() - 1;
  }
  return frames;
}

}  // namespace planar
