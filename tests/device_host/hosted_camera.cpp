#include "device_host/hosted_camera.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace planar::test {
namespace {

using Fault = HostedCamera::Fault;

constexpr double kLostShare = 1.0 / 3.0;

/// An exposure that can freeze.
class Sensor {
 public:
  explicit Sensor(Exposure exposure) : exposure_(std::move(exposure)) {}

  std::atomic<bool> frozen{false};

  Exposure exposure() {
    return [this](const cv::Rect& region_px, double brightness) {
      if (!frozen || last_.size() != region_px.size()) last_ = exposure_(region_px, brightness);
      return last_;
    };
  }

 private:
  Exposure exposure_;
  cv::Mat last_;
};

class HostedGige final : public HostedCamera {
 public:
  HostedGige(const cv::Size& sensor_px, double frame_rate_hz, Exposure exposure)
      : sensor_px_(sensor_px), frame_rate_hz_(frame_rate_hz), sensor_(std::move(exposure)) {
    power_up();
  }

  void set_fault(Fault fault) override {
    if (fault == Fault::kTruncated)
      throw std::invalid_argument("a GigE camera loses packets; it truncates no payload");
    sensor_.frozen = fault == Fault::kFrozen;
    if (fault == Fault::kDead) return camera_.reset();
    if (!camera_) power_up();
    camera_->lose_packets(fault == Fault::kPacketLoss ? kLostShare : 0.0);
  }

 private:
  void power_up() {
    camera_ = std::make_unique<GigeCamera>(kHostedAddress, kHostedSerial, sensor_px_,
                                           frame_rate_hz_, sensor_.exposure());
  }

  cv::Size sensor_px_;
  double frame_rate_hz_;
  Sensor sensor_;
  std::unique_ptr<GigeCamera> camera_;
};

class HostedUsb final : public HostedCamera {
 public:
  HostedUsb(MockUsbBus& bus, const cv::Size& sensor_px, double frame_rate_hz, Exposure exposure)
      : sensor_(std::move(exposure)),
        camera_(kHostedSerial, sensor_px, frame_rate_hz, sensor_.exposure()),
        device_(bus, camera_.description(), camera_) {}

  void set_fault(Fault fault) override {
    if (fault == Fault::kPacketLoss)
      throw std::invalid_argument("USB loses no packets; its frames are truncated");
    sensor_.frozen = fault == Fault::kFrozen;
    camera_.truncate_payloads(fault == Fault::kTruncated ? std::numeric_limits<int>::max() : 0);
    if (fault == Fault::kDead && plugged_) {
      device_.unplug();
      camera_.power_cycle();
    }
    if (fault != Fault::kDead && !plugged_) device_.plug();
    plugged_ = fault != Fault::kDead;
  }

 private:
  Sensor sensor_;
  Usb3Camera camera_;
  MockUsbDevice device_;
  bool plugged_{true};
};

}  // namespace

const std::vector<std::string>& HostedCamera::fault_names() {
  static const std::vector<std::string> names{"packet-loss", "truncated", "dead", "frozen"};
  return names;
}

Fault HostedCamera::fault_named(const std::string& name) {
  const auto& names = fault_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::invalid_argument("unknown fault " + name);
  return static_cast<Fault>(found - names.begin());
}

std::unique_ptr<HostedCamera> host_gige_camera(const cv::Size& sensor_px, double frame_rate_hz,
                                               Exposure exposure) {
  return std::make_unique<HostedGige>(sensor_px, frame_rate_hz, std::move(exposure));
}

std::unique_ptr<HostedCamera> host_usb_camera(MockUsbBus& bus, const cv::Size& sensor_px,
                                              double frame_rate_hz, Exposure exposure) {
  return std::make_unique<HostedUsb>(bus, sensor_px, frame_rate_hz, std::move(exposure));
}

}  // namespace planar::test
