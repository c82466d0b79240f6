#include "planar_servo/hardware/cameras/aravis_camera.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cameras/aravis_link.h"
#include "planar_servo/hardware/cameras/frame_mailbox.h"

namespace planar {
namespace {

// Faults of the camera must stop the arm within 3 frame periods or 100 ms, whichever is longer.
// These limits leave part of that time to the polling caller and to the drives' link.
constexpr double kAgeLimitPeriods = 2.25;
constexpr double kAgeLimit_s = 0.070;

constexpr double kStartTime_s = 0.5;  ///< allowed until a stream's first frame
/// Reopen the camera after as long without a good frame, the second where frames come slowly.
constexpr double kSilence_s = 3.0, kLongestSilence_s = 12.0;
constexpr double kLinkPollPeriod_s = 0.005;
constexpr double kLateness_s = 0.5;         ///< a frame as late counts as lost; restart the stream
constexpr double kLongestLateness_s = 4.0;  ///< the same of a camera that is slow, on command
constexpr double kSlack = 2.0;  ///< a frame may take this many times as long as the last
constexpr double kFirstReopenPause_s = 0.1;  ///< first pause between attempts to open a lost camera
constexpr double kLongestReopenPause_s = 2.0;
constexpr double kReadBackPeriod_s = 0.1;  ///< of one setting, which others may have changed

AravisSettings checked(const AravisSettings& settings) {
  require_settings(settings);
  return settings;
}

class AravisCamera final : public FrameSource {
 public:
  explicit AravisCamera(const AravisSettings& settings)
      : exposure_{settings.exposure_s, settings.gain_db},
        settings_(checked(settings)),
        memory_(settings_),
        mailbox_({{}, settings_.sensor_px},
                 std::max(kAgeLimitPeriods / settings_.frame_rate_hz, kAgeLimit_s)) {
    open();
    thread_ = std::thread([this] { run(); });
  }

  ~AravisCamera() override {
    stop_ = true;
    mailbox_.wake();
    thread_.join();
  }
  AravisCamera(const AravisCamera&) = delete;
  AravisCamera& operator=(const AravisCamera&) = delete;

  cv::Size sensor_size_px() const override { return settings_.sensor_px; }

  void set_region(const cv::Rect& region_px) override {
    require_region(region_px, sensor_size_px());
    const bool restarts = region_px.size() != mailbox_.region().size();
    mailbox_.ask_region(region_px);
    if (restarts) next_frame();  // the first frame shows that the camera is watched again
  }

  FrameResult next_frame() override { return mailbox_.next(patience_s()); }
  FrameResult following_frame() override { return mailbox_.following(patience_s()); }
  std::optional<std::string> fault() const override { return mailbox_.fault(); }
  FrameCounts counts() const override { return mailbox_.counts(); }

  std::vector<std::pair<std::string, std::string>> features() const override {
    const std::lock_guard<std::mutex> lock(order_mutex_);
    return features_;
  }

  CameraExposure exposure() const override { return exposure_; }

  void set_exposure(const CameraExposure& exposure) override {
    require_exposure(exposure);
    if (exposure.time_s * settings_.frame_rate_hz >= 1.0)
      throw InputError(exposure_too_long(exposure.time_s, settings_.frame_rate_hz));
    std::unique_lock<std::mutex> lock(order_mutex_);
    exposure_order_.emplace(ExposureOrder{exposure, {}});
    std::future<void> done = exposure_order_->done.get_future();
    lock.unlock();
    done.get();
    exposure_ = exposure;
  }

 private:
  /// An exposure that a caller wants, and the promise by which the camera's thread reports the
  /// outcome.
  struct ExposureOrder {
    CameraExposure exposure;
    std::promise<void> done;
  };

  void open() {
    delivers_ = false;
    link_ = std::make_unique<AravisLink>(settings_, memory_);
    settings_.id = link_->id();  // no other takes its place
    note_features();
    start(mailbox_.region());
  }

  void start(const cv::Rect& region_px) {
    mailbox_.excuse(kStartTime_s);
    asked_px_ = region_px;
    link_->start(region_px);
    mailbox_.excuse(kStartTime_s);
  }

  void run() {
    while (!stop_) {
      try {
        if (!link_) {
          unanswered_s_.reset();
          open();
        }
        grab();
      } catch (const std::exception& error) {
        const std::string why = fmt::format("the camera is lost: {}", error.what());
        if (why != std::exchange(loss_, why)) spdlog::warn(why);
        mailbox_.lose(why);
        refuse_order(why);
        link_.reset();
        rest(pause_s_);
        pause_s_ = std::min(2.0 * pause_s_, kLongestReopenPause_s);
      }
    }
    link_.reset();
  }

  /// Notes that a whole frame has come, which alone shows that the camera delivers.
  void find() {
    pause_s_ = kFirstReopenPause_s;
    if (std::exchange(loss_, "").empty()) return;
    mailbox_.find();
    silence_s_ = std::min(kSlack * silence_s_, kLongestSilence_s);
    spdlog::info(
        fmt::format("the camera is back; from now on it may be silent for {:g} s", silence_s_));
  }

  void require_frames() {
    const double age_s = mailbox_.age_s();
    if (link_->lost()) throw WorkError("it does not answer", Cause::kDevice);
    if (age_s <= silence_s_ + lateness_s_ - kLateness_s) return;
    if (delivers_)
      throw WorkError(fmt::format("it sent no good frame for {:.0f} s", age_s), Cause::kDevice);
    throw WorkError(
        "it answers, but none of its frames arrives: it or this machine is too slow, or a cable, "
        "on GigE a firewall, rp_filter or too large packets stop them; planar-doctor examines it",
        Cause::kDevice);
  }

  void rest(double duration_s) {
    const double until_s = clock_.now_s() + duration_s;
    while (!stop_ && clock_.now_s() < until_s) clock_.sleep_for_s(kLinkPollPeriod_s);
  }

  /// Grabs frames until `stop_` is set or the connection fails.
  void grab() {
    while (!stop_) {
      if (!unanswered_s_) {
        follow_exposure();
        follow_region();
      }
      if (settings_.trigger == CameraTrigger::kSoftware)
        grab_by_command();
      else
        grab_unasked();
      require_frames();
      if (!unanswered_s_ && clock_.now_s() > read_back_s_) {
        read_back_s_ = clock_.now_s() + kReadBackPeriod_s;
        link_->require_unchanged();
      }
    }
  }

  void note_features() {
    const std::lock_guard<std::mutex> lock(order_mutex_);
    features_ = link_->features();
  }

  void follow_exposure() {
    std::unique_lock<std::mutex> lock(order_mutex_);
    auto order = std::exchange(exposure_order_, std::nullopt);
    lock.unlock();
    if (!order) return;
    try {
      link_->expose(order->exposure);
    } catch (const std::exception&) {
      order->done.set_exception(std::current_exception());
      link_->expose({settings_.exposure_s, settings_.gain_db});  // lost if this fails, too
      return;
    }
    settings_.exposure_s = order->exposure.time_s;
    settings_.gain_db = order->exposure.gain_db;
    note_features();
    order->done.set_value();
  }

  /// How long a caller waits: where frames take long, for the one under way and its own.
  double patience_s() const {
    const double wait_s = lateness_s_ > kLateness_s ? kSlack * lateness_s_ : 0.0;
    return std::max(settings_.timeout_s, wait_s);
  }

  /// Fails an order that waits for a camera that is lost.
  void refuse_order(const std::string& why) {
    const std::lock_guard<std::mutex> lock(order_mutex_);
    if (auto order = std::exchange(exposure_order_, std::nullopt))
      order->done.set_exception(std::make_exception_ptr(WorkError(why, Cause::kDevice)));
  }

  void follow_region() {
    const cv::Rect region_px = mailbox_.region();
    if (region_px == asked_px_) return;
    if (region_px.size() != asked_px_.size()) {
      start(region_px);
    } else {
      link_->move(region_px);
      asked_px_ = region_px;
    }
  }

  /// Takes frames as they come. A frame that comes too late starts a new stream, which empties any
  /// queue in the camera.
  void grab_unasked() {
    const auto arrival = link_->receive(kLinkPollPeriod_s);
    take(arrival, std::nullopt);
    if (arrival && arrival->late_s > kLateness_s) link_->start(asked_px_);
  }

  /// Triggers one exposure and waits for its frame before the next, so that a late frame is not
  /// mistaken for the next trigger's.
  void grab_by_command() {
    if (!unanswered_s_ && !trigger()) return;
    const auto arrival = link_->receive(kLinkPollPeriod_s);
    const double took_s = clock_.now_s() - *unanswered_s_ - settings_.exposure_s;
    if (arrival) {
      if (arrival->complete) expect_as_late(took_s);
      take(arrival, std::exchange(unanswered_s_, std::nullopt));
    } else if (took_s > lateness_s_) {
      unanswered_s_.reset();
      lateness_s_ = std::min(kSlack * lateness_s_, kLongestLateness_s);
      mailbox_.note_bad(FrameStatus::kTimeout);
      link_->start(asked_px_);  // the lost frame cannot come in a new stream
    }
  }

  void expect_as_late(double took_s) {
    lateness_s_ = std::clamp(kSlack * took_s, kLateness_s, kLongestLateness_s);
    if (took_s > kLateness_s && !std::exchange(slow_, true))
      spdlog::warn(fmt::format(
          "the camera or this machine is slow: a frame came {:.1f} s after its command; "
          "frames are waited for, but the arm does not move by them",
          took_s));
  }

  bool trigger() {
    mailbox_.sleep_until(next_trigger_s_, asked_px_);
    if (stop_ || mailbox_.region() != asked_px_) return false;
    unanswered_s_ = clock_.now_s();
    next_trigger_s_ = *unanswered_s_ + 1.0 / settings_.frame_rate_hz;
    link_->trigger();
    return true;
  }

  /// Takes a frame whose exposure began at `began_s`; if that is unknown, it follows from the
  /// arrival.
  void take(const std::optional<AravisLink::Arrival>& arrival, std::optional<double> began_s) {
    if (!arrival) return;
    delivers_ = true;
    if (!arrival->complete || arrival->repeated) {
      mailbox_.note_bad(arrival->complete ? FrameStatus::kFrozen : FrameStatus::kIncomplete);
      return;
    }
    find();
    const double t_s = began_s.value_or(arrival->due_s - settings_.exposure_s);
    const cv::Rect& region_px = arrival->region_px;
    if ((region_px & asked_px_) != asked_px_) {  // exposed before the region moved
      mailbox_.note_good(t_s, {});
      return;
    }
    if (!mailbox_.note_good(t_s, asked_px_)) return;
    mailbox_.deliver({unpack(settings_.pixel_format, arrival->data, region_px.size()), region_px,
                      t_s, arrival->id});
  }

  CameraExposure exposure_;  ///< as the caller knows it
  AravisSettings settings_;
  FrameMemory memory_;
  FrameMailbox mailbox_;
  SteadyClock clock_;
  std::unique_ptr<AravisLink> link_;
  cv::Rect asked_px_;  ///< the region last sent to the camera, as it was asked for
  double next_trigger_s_{0.0};
  std::string loss_;                     ///< why there is no camera; empty while it delivers
  bool delivers_{false};                 ///< anything since it was opened
  double silence_s_{kSilence_s};         ///< after which it is opened again
  double pause_s_{kFirstReopenPause_s};  ///< before it is opened again
  std::atomic<double> lateness_s_{kLateness_s};  ///< after which a commanded frame counts as lost
  bool slow_{false};                             ///< and this was said
  std::optional<double> unanswered_s_;  ///< when the trigger was sent whose frame has not come
  double read_back_s_{0.0};             ///< when a setting is read back next
  mutable std::mutex order_mutex_;
  std::vector<std::pair<std::string, std::string>> features_;  ///< of the camera
  std::optional<ExposureOrder> exposure_order_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<FrameSource> open_aravis_camera(const AravisSettings& settings) {
  return std::make_unique<AravisCamera>(settings);
}

}  // namespace planar
