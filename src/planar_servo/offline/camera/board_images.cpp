#include "planar_servo/offline/camera/board_images.h"

#include "planar_servo/offline/grey_image.h"

namespace planar {

cv::Mat read_grey(const std::filesystem::path& file, Faults& faults) {
  cv::Mat image = read_grey_image(file);
  if (image.empty())
    faults.add(file.string() +
               ": cannot be read to its end as an image; a picture such as PNG or PGM is needed");
  return image;
}

BoardSight find_board_on_sensor(const cv::Mat& image, const cv::Point& corner_px,
                                const Board& board) {
  BoardSight sight = find_board(image, board);
  for (Eigen::Vector2d& pixel : sight.pixels) pixel += Eigen::Vector2d(corner_px.x, corner_px.y);
  return sight;
}

}  // namespace planar
