#include "planar_servo/offline/saved_frames.h"

#include <fmt/format.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {

std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell) {
  const PictureSet pictures(images);
  const cv::Size sensor_px(cell.camera.width_px, cell.camera.height_px);
  std::vector<Frame> frames;
  for (const std::filesystem::path& image : images) {
    Frame frame{pictures.read(image), {{}, sensor_px}, 0.0, frames.size()};
    if (frame.image.empty()) throw InputError({"is no picture that can be read", "", image});
    if (frame.image.size() != sensor_px)
      throw InputError({fmt::format("is {} x {} px, the cell's sensor {} x {}", frame.image.cols,
                                    frame.image.rows, sensor_px.width, sensor_px.height),
                        "give whole pictures of the cell's camera", image});
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace planar
