#include "planar_servo/console/picture_watch.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/work/jog/lamp_finder.h"

namespace planar {
namespace {

/// A virtual cell's clock that keeps to the real time while somebody waits by it.
class PacedClock final : public Clock {
 public:
  PacedClock(Clock& clock, bool paces) : clock_(clock), paces_(paces) {}

  double now_s() const override { return clock_.now_s(); }
  void sleep_for_s(double duration_s) override {
    clock_.sleep_for_s(duration_s);
    if (!paces_) return;
    const double behind_s = steady_.now_s() - clock_.now_s() - offset_s_;
    if (behind_s < 0.0) steady_.sleep_for_s(-behind_s);
    if (behind_s > kMostBehind_s) offset_s_ = steady_.now_s() - clock_.now_s();
  }

 private:
  /// What was lost is made up for, but not the time in which nobody waited.
  static constexpr double kMostBehind_s = 0.05;

  Clock& clock_;
  bool paces_;
  SteadyClock steady_;
  double offset_s_{steady_.now_s() - clock_.now_s()};
};

class WatchedCamera final : public FrameSource {
 public:
  WatchedCamera(FrameSource& camera, const DeviceWatch& watch) : camera_(camera), watch_(watch) {}

  cv::Size sensor_size_px() const override { return camera_.sensor_size_px(); }
  void set_region(const cv::Rect& region_px) override { camera_.set_region(region_px); }
  FrameResult next_frame() override { return shown(camera_.next_frame()); }
  FrameResult following_frame() override { return shown(camera_.following_frame()); }
  std::optional<std::string> fault() const override {
    auto fault = camera_.fault();
    watch_.camera_fault(fault);
    return fault;
  }
  FrameCounts counts() const override { return camera_.counts(); }
  std::vector<std::pair<std::string, std::string>> features() const override {
    return camera_.features();
  }
  CameraExposure exposure() const override { return camera_.exposure(); }
  void set_exposure(const CameraExposure& exposure) override { camera_.set_exposure(exposure); }

 private:
  FrameResult shown(FrameResult result) {
    if (result.status == FrameStatus::kOk) watch_.frame(result.frame);
    return result;
  }

  FrameSource& camera_;
  const DeviceWatch& watch_;
};

class WatchedDrives final : public ForwardingDrives {
 public:
  WatchedDrives(DriveGroup& drives, const DeviceWatch& watch)
      : ForwardingDrives(drives), watch_(watch) {}

  std::array<DriveStatus, 3> status() override {
    auto status = ForwardingDrives::status();
    watch_.drives(status);
    return status;
  }

 private:
  const DeviceWatch& watch_;
};

class WatchedDevices final : public CellDevices {
 public:
  WatchedDevices(std::unique_ptr<CellDevices> devices, bool is_virtual, DeviceWatch watch)
      : devices_(std::move(devices)),
        watch_(std::move(watch)),
        clock_(devices_->clock(), is_virtual),
        camera_(devices_->camera(), watch_),
        drives_(devices_->drives(), watch_) {}

  Clock& clock() override { return clock_; }
  FrameSource& camera() override { return camera_; }
  DriveGroup& drives() override { return drives_; }
  Tracker& tracker() override { return devices_->tracker(); }
  BoardPresenter* board_presenter() override { return devices_->board_presenter(); }
  std::shared_ptr<Judge> truth() override { return devices_->truth(); }

 private:
  std::unique_ptr<CellDevices> devices_;
  DeviceWatch watch_;
  PacedClock clock_;
  WatchedCamera camera_;
  WatchedDrives drives_;
};

constexpr int kQuality = 80;         // of 100
constexpr double kOlderShare = 0.5;  // brightness of what is older than the region

std::shared_ptr<const std::string> jpeg_of(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return std::make_shared<const std::string>(bytes.begin(), bytes.end());
}

/// Returns the image in a size that is not larger. Halving is many times faster than other ratios.
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

LampState lamp_state(const SightedLamps& sight, std::size_t i) {
  const LampCenter& lamp = sight.lamps[i];
  return {lamp.uv_px, sight.edges_px[i], lamp.look.level >= kWhite};
}

}  // namespace

std::unique_ptr<CellDevices> watched(std::unique_ptr<CellDevices> devices, bool is_virtual,
                                     DeviceWatch watch) {
  return std::make_unique<WatchedDevices>(std::move(devices), is_virtual, std::move(watch));
}

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
      state.lamps = std::array{lamp_state(*sight, 0), lamp_state(*sight, 1)};
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
