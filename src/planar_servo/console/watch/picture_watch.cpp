#include "planar_servo/console/watch/picture_watch.h"
#include <algorithm>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/work/jog/lamp_finder.h"

namespace planar {
namespace {

constexpr int kQuality = 80;         // of 100
constexpr double kOlderShare = 0.5;  // brightness of what is older than the region

std::shared_ptr<const std::string> jpeg_of(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return std::make_shared<const std::string>(bytes.begin(), bytes.end());
}

/// Returns the image in a size that is not larger. Halving is many times faster than any other
/// ratio.
cv::Mat shrunk(cv::Mat image, const cv::Size& size) {
  while (image.cols >= 2 * size.width && image.rows >= 2 * size.height) {
    cv::Mat half;
    cv::resize(image, half, image.size() / 2, 0.0, 0.0, cv::INTER_AREA);
    image = half;
  }
  cv::Mat fitted;
  cv::resize(image, fitted, size, 0.0, 0.0, cv::INTER_AREA);
  return fitted;
}

cv::Rect scaled(const cv::Rect& region_px, double scale) {
  const cv::Point corner(cvRound(region_px.x * scale), cvRound(region_px.y * scale));
  return {corner, cv::Size(std::max(1, cvRound(region_px.width * scale)),
                           std::max(1, cvRound(region_px.height * scale)))};
}

constexpr double kWhite = 255.0;
constexpr double kExamineFrameEvery_s = 0.15;

std::array<LampState, 2> lamp_states(const SightedLamps& sight) {
  std::array<LampState, 2> states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const LampCenter& lamp = sight.lamps[i];
    states[i] = {lamp.uv_px, sight.edges_px[i], lamp.look.level >= kWhite};
  }
  return states;
}

}  // namespace

std::uint64_t Pictures::take(const Frame& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (frame.region_px.size() == sensor_px_) {
    shown_.whole = frame;
    shown_.region.reset();
  } else {
    shown_.region = frame;
  }
  return ++shown_.number;
}

void Pictures::aim(const std::array<Eigen::Vector2d, 2>& lamps_px) {
  const std::lock_guard<std::mutex> lock(mutex_);
  shown_.lamps_px = lamps_px;
  shown_.aimed = true;
}

Pictures::Shown Pictures::shown() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return shown_;
}

cv::Mat Pictures::composed(const Shown& shown) const {
  const double scale = std::min(1.0, static_cast<double>(kMostWidth_px) / sensor_px_.width);
  const cv::Size size = scaled({{}, sensor_px_}, scale).size();
  cv::Mat image = shown.whole ? shrunk(shown.whole->image, size) : cv::Mat::zeros(size, CV_8UC1);
  if (!shown.region) return image;
  image *= kOlderShare;
  const cv::Rect place = scaled(shown.region->region_px, scale) & cv::Rect({}, size);
  if (!place.empty()) shrunk(shown.region->image, place.size()).copyTo(image(place));
  return image;
}

Pictures::Jpeg Pictures::whole() {
  const std::lock_guard<std::mutex> lock(whole_.mutex);
  const Shown now = shown();
  if (now.number != whole_.jpeg.number) whole_.jpeg = {jpeg_of(composed(now)), now.number};
  return whole_.jpeg;
}

Pictures::Jpeg Pictures::lamp(std::size_t index) {
  Encoded& lamp = lamps_.at(index);
  const std::lock_guard<std::mutex> lock(lamp.mutex);
  const Shown now = shown();
  const std::optional<Frame>& frame = now.region ? now.region : now.whole;
  if (!frame || !now.aimed) return {};
  if (now.number == lamp.jpeg.number) return lamp.jpeg;
  const Eigen::Vector2d corner(frame->region_px.x, frame->region_px.y);
  const cv::Rect window = window_round(now.lamps_px.at(index) - corner, 0.5 * kLampSide_px);
  const cv::Rect there = window & cv::Rect({}, frame->image.size());
  cv::Mat image = cv::Mat::zeros(kLampSide_px, kLampSide_px, CV_8UC1);
  const cv::Rect here = (there - window.tl()) & cv::Rect({}, image.size());
  if (!here.empty()) frame->image(here + window.tl()).copyTo(image(here));
  lamp.jpeg = {jpeg_of(image), now.number};
  return lamp.jpeg;
}

PictureWatch::PictureWatch(const CellSettings& cell, const std::optional<VisionCalibration>& vision,
                           StateBoard& board)
    : board_(board),
      pictures_({cell.camera.width_px, cell.camera.height_px}),
      method_(cell.lamps.method) {
  if (vision) fixed_ = vision->reference_lamps;
}

void PictureWatch::take(const Frame& frame, bool is_watched) {
  const std::uint64_t number = pictures_.take(frame);
  board_.change([&](CellState& state) {
    state.picture = number;
    state.picture_s = clock_.now_s();
  });
  if (!is_watched || clock_.now_s() - examined_s_ < kExamineFrameEvery_s) return;
  examined_s_ = clock_.now_s();
  examine(frame);
}

void PictureWatch::examine(const Frame& frame) {
  const auto sight = sight_lamps(frame, places_px(fixed_), lamps_px_);
  lamps_px_.reset();
  if (sight) {
    lamps_px_ = LampPixels{sight->lamps[0].uv_px, sight->lamps[1].uv_px};
    pictures_.aim(*lamps_px_);
    best_px_ = std::min(sight->mean_edge_px(), best_px_.value_or(sight->mean_edge_px()));
  }
  const bool is_whole = frame.region_px.size() == pictures_.sensor_px();
  auto fixed = is_whole ? fixed_lamps(frame) : std::vector<FixedLampState>();
  board_.change([&](CellState& state) {
    state.lamps.reset();
    state.edge_px.reset();
    state.best_edge_px = best_px_;
    if (sight) {
      state.lamps = lamp_states(*sight);
      state.edge_px = sight->mean_edge_px();
    }
    if (is_whole) state.fixed_lamps = std::move(fixed);
  });
}

std::vector<FixedLampState> PictureWatch::fixed_lamps(const Frame& frame) {
  std::vector<FixedLampState> states;
  for (const ReferenceLamp& lamp : fixed_)
    if (const auto seen = find_fixed_light(frame, lamp.uv_px, detector_, method_))
      states.push_back({lamp.id, seen->uv_px, (seen->uv_px - lamp.uv_px).norm()});
  return states;
}

}  // namespace planar
