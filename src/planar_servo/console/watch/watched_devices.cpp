#include "planar_servo/console/watch/watched_devices.h"

#include <utility>

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

class WatchedDrives final : public DriveGroup {
 public:
  WatchedDrives(DriveGroup& drives, const DeviceWatch& watch) : drives_(drives), watch_(watch) {}

  void energize() override { drives_.energize(); }
  void set_limits(const std::array<DriveLimits, 3>& limits) override { drives_.set_limits(limits); }
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override {
    drives_.set_targets(targets_pulses);
  }
  void halt() override { drives_.halt(); }
  std::array<DriveStatus, 3> status() override {
    auto status = drives_.status();
    watch_.drives(status);
    return status;
  }
  void start_homing(int joint, HomeDirection direction) override {
    drives_.start_homing(joint, direction);
  }
  void set_position(int joint, std::int32_t position_pulses) override {
    drives_.set_position(joint, position_pulses);
  }
  std::optional<std::string> stream_refusal() const override { return drives_.stream_refusal(); }
  void reconnect() override { drives_.reconnect(); }

 private:
  DriveGroup& drives_;
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

}  // namespace

std::unique_ptr<CellDevices> watched(std::unique_ptr<CellDevices> devices, bool is_virtual,
                                     DeviceWatch watch) {
  return std::make_unique<WatchedDevices>(std::move(devices), is_virtual, std::move(watch));
}

}  // namespace planar
