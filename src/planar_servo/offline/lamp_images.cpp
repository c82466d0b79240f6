#include "planar_servo/offline/lamp_images.h"

#include <fmt/format.h>

#include <utility>

namespace planar {
namespace {

std::vector<LampImage> as_one_set(std::vector<LampImage> images) {
  std::vector<std::filesystem::path> files;
  files.reserve(images.size());
  for (const LampImage& image : images) files.push_back(image.file);
  const auto set = std::make_shared<const PictureSet>(files);
  for (LampImage& image : images) image.set = set;
  return images;
}

}  // namespace

std::vector<LampImage> images_of_recording(const std::filesystem::path& folder,
                                           const std::vector<FrameRow>& frames,
                                           const std::optional<PlanarArm>& arm) {
  std::vector<LampImage> images;
  for (const FrameRow& frame : frames) {
    LampImage image;
    image.id = frame.id;
    image.name = frame.image;
    image.file = folder / frame.image;
    image.t_s = frame.t_s;
    image.region_px = frame.region_px;
    image.shows_board = shows_board(frame.plan);
    if (arm && !image.shows_board) image.commanded = arm->forward(frame.theta);
    images.push_back(std::move(image));
  }
  return as_one_set(std::move(images));
}

std::vector<LampImage> single_images(const std::vector<std::filesystem::path>& files) {
  std::vector<LampImage> images;
  for (const std::filesystem::path& file : files) {
    LampImage image;
    image.id = file.stem().string();
    image.name = file.string();
    image.file = file;
    images.push_back(std::move(image));
  }
  return as_one_set(std::move(images));
}

LampImageRead read_lamp_image(const LampImage& image, const std::optional<cv::Size>& sensor_px) {
  LampImageRead read;
  if (image.shows_board) {
    read.status = LampStatus::kBoardView;
    return read;
  }
  read.frame.image = image.set->read(image.file);
  if (read.frame.image.empty()) {
    read.status = LampStatus::kUnreadable;
    return read;
  }
  const cv::Size size = read.frame.image.size();
  read.frame.region_px = image.region_px.value_or(cv::Rect({0, 0}, size));
  read.frame.t_s = image.t_s.value_or(0.0);
  const cv::Size expected = image.region_px ? image.region_px->size() : sensor_px.value_or(size);
  if (size != expected) {
    read.status = LampStatus::kWrongSize;
    read.fault = fmt::format(
        "{}: is {} x {} pixels; {} says {} x {}", image.file.string(), size.width, size.height,
        image.region_px ? "frames.csv" : "the cell file", expected.width, expected.height);
  }
  return read;
}

}  // namespace planar
