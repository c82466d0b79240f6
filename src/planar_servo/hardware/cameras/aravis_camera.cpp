#include "planar_servo/hardware/cameras/aravis_camera.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
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
constexpr double kOrderTime_s = 5.0;       ///< allowed to the thread and the camera

AravisSettings checked(const AravisSettings& settings) {
  require_settings(settings);
  return settings;
}

}  // namespace

struct AravisCamera::Impl {
  /// An exposure that a caller wants, and the promise by which the camera's thread reports the
  /// outcome.
  struct ExposureOrder {
    CameraExposure exposure;
    std::promise<void> done;
  };

  explicit Impl(const AravisSettings& wanted)
      : settings(checked(wanted)),
        format(pixel_format_named(settings.pixel_format)),
        memory(settings),
        mailbox({{}, settings.sensor_px},
                std::max(kAgeLimitPeriods / settings.frame_rate_hz, kAgeLimit_s)) {
    open();
    thread = std::thread([this] { run(); });
  }

  ~Impl() {
    stop = true;
    mailbox.wake();
    thread.join();
  }

  void open() {
    delivers = false;
    link = std::make_unique<AravisLink>(settings, memory);
    note_features();
    start(mailbox.region());
  }

  void start(const cv::Rect& region_px) {
    mailbox.excuse(kStartTime_s);
    asked_px = region_px;
    link->start(region_px);
    mailbox.excuse(kStartTime_s);
  }

  void run() {
    while (!stop) {
      try {
        if (!link) {
          unanswered_s.reset();
          open();
        }
        grab();
      } catch (const std::exception& error) {
        const std::string why = fmt::format("the camera is lost: {}", error.what());
        if (why != std::exchange(loss, why)) spdlog::warn(why);
        mailbox.lose(why);
        link.reset();
        rest(pause_s);
        pause_s = std::min(2.0 * pause_s, kLongestReopenPause_s);
      }
    }
    link.reset();
  }

  /// Notes that a whole frame has come, which alone shows that the camera delivers.
  void find() {
    pause_s = kFirstReopenPause_s;
    if (std::exchange(loss, "").empty()) return;
    mailbox.find();
    silence_s = std::min(kSlack * silence_s, kLongestSilence_s);
    spdlog::info(
        fmt::format("the camera is back; from now on it may be silent for {:g} s", silence_s));
  }

  void require_frames() {
    const double age_s = mailbox.age_s();
    if (link->lost()) throw WorkError("it does not answer", Cause::kDevice);
    if (age_s <= silence_s + lateness_s - kLateness_s) return;
    if (delivers)
      throw WorkError(fmt::format("it sent no good frame for {:.0f} s", age_s), Cause::kDevice);
    throw WorkError(
        "it answers, but none of its frames arrives: it or this machine is too slow, or a cable, "
        "on GigE a firewall, rp_filter or too large packets stop them; planar-doctor examines it",
        Cause::kDevice);
  }

  void rest(double duration_s) {
    const double until_s = clock.now_s() + duration_s;
    while (!stop && clock.now_s() < until_s) clock.sleep_for_s(kLinkPollPeriod_s);
  }

  /// Grabs frames until `stop` is set or the connection fails.
  void grab() {
    while (!stop) {
      if (!unanswered_s) {
        follow_exposure();
        follow_region();
      }
      if (settings.trigger == CameraTrigger::kSoftware)
        grab_by_command();
      else
        grab_unasked();
      require_frames();
      if (!unanswered_s && clock.now_s() > read_back_s) {
        read_back_s = clock.now_s() + kReadBackPeriod_s;
        link->require_unchanged();
      }
    }
  }

  void note_features() {
    const std::lock_guard<std::mutex> lock(order_mutex);
    features = link->features();
  }

  void follow_exposure() {
    std::unique_lock<std::mutex> lock(order_mutex);
    auto order = std::exchange(exposure_order, std::nullopt);
    lock.unlock();
    if (!order) return;
    try {
      link->expose(order->exposure);
    } catch (const std::exception&) {
      order->done.set_exception(std::current_exception());
      link->expose({settings.exposure_s, settings.gain_db});  // lost if this fails, too
      return;
    }
    settings.exposure_s = order->exposure.time_s;
    settings.gain_db = order->exposure.gain_db;
    note_features();
    order->done.set_value();
  }

  std::future<void> order(const CameraExposure& exposure) {
    const std::lock_guard<std::mutex> lock(order_mutex);
    exposure_order.emplace(ExposureOrder{exposure, {}});
    return exposure_order->done.get_future();
  }

  /// How long a caller waits: where frames take long, for the one under way and its own.
  double patience_s() const {
    const double wait_s = lateness_s > kLateness_s ? kSlack * lateness_s : 0.0;
    return std::max(settings.timeout_s, wait_s);
  }

  void withdraw_order() {
    const std::lock_guard<std::mutex> lock(order_mutex);
    exposure_order.reset();
  }

  void follow_region() {
    const cv::Rect region_px = mailbox.region();
    if (region_px == asked_px) return;
    if (region_px.size() != asked_px.size()) {
      start(region_px);
    } else {
      link->move(region_px);
      asked_px = region_px;
    }
  }

  /// Takes frames as they come. A frame that comes too late starts a new stream, which empties any
  /// queue in the camera.
  void grab_unasked() {
    const auto arrival = link->receive(kLinkPollPeriod_s);
    take(arrival, std::nullopt);
    if (arrival && arrival->late_s > kLateness_s) link->start(asked_px);
  }

  /// Triggers one exposure and waits for its frame before the next, so that a late frame is not
  /// mistaken for the next trigger's.
  void grab_by_command() {
    if (!unanswered_s && !trigger()) return;
    const auto arrival = link->receive(kLinkPollPeriod_s);
    const double took_s = clock.now_s() - *unanswered_s - settings.exposure_s;
    if (arrival) {
      if (arrival->complete) expect_as_late(took_s);
      take(arrival, std::exchange(unanswered_s, std::nullopt));
    } else if (took_s > lateness_s) {
      unanswered_s.reset();
      lateness_s = std::min(kSlack * lateness_s, kLongestLateness_s);
      mailbox.note_bad(FrameStatus::kTimeout);
      link->start(asked_px);  // the lost frame cannot come in a new stream
    }
  }

  void expect_as_late(double took_s) {
    lateness_s = std::clamp(kSlack * took_s, kLateness_s, kLongestLateness_s);
    if (took_s > kLateness_s && !std::exchange(slow, true))
      spdlog::warn(fmt::format(
          "the camera or this machine is slow: a frame came {:.1f} s after its command; "
          "frames are waited for, but the arm does not move by them",
          took_s));
  }

  bool trigger() {
    mailbox.sleep_until(next_trigger_s, asked_px);
    if (stop || mailbox.region() != asked_px) return false;
    unanswered_s = clock.now_s();
    next_trigger_s = *unanswered_s + 1.0 / settings.frame_rate_hz;
    link->trigger();
    return true;
  }

  /// Takes a frame whose exposure began at `began_s`; if that is unknown, it follows from the
  /// arrival.
  void take(const std::optional<AravisLink::Arrival>& arrival, std::optional<double> began_s) {
    if (!arrival) return;
    delivers = true;
    if (!arrival->complete || arrival->repeated) {
      mailbox.note_bad(arrival->complete ? FrameStatus::kFrozen : FrameStatus::kIncomplete);
      return;
    }
    find();
    const double t_s = began_s.value_or(arrival->due_s - settings.exposure_s);
    const cv::Rect& region_px = arrival->region_px;
    if ((region_px & asked_px) != asked_px) {  // exposed before the region moved
      mailbox.note_good(t_s, {});
      return;
    }
    if (!mailbox.note_good(t_s, asked_px)) return;
    mailbox.deliver({unpack(format, arrival->data, region_px.size()), region_px, t_s, arrival->id});
  }

  AravisSettings settings;
  PixelFormat format;
  FrameMemory memory;
  FrameMailbox mailbox;
  SteadyClock clock;
  std::unique_ptr<AravisLink> link;
  cv::Rect asked_px;  ///< the region last sent to the camera, as it was asked for
  double next_trigger_s{0.0};
  std::string loss;                             ///< why there is no camera; empty while it delivers
  bool delivers{false};                         ///< anything since it was opened
  double silence_s{kSilence_s};                 ///< after which it is opened again
  double pause_s{kFirstReopenPause_s};          ///< before it is opened again
  std::atomic<double> lateness_s{kLateness_s};  ///< after which a commanded frame counts as lost
  bool slow{false};                             ///< and this was said
  std::optional<double> unanswered_s;  ///< when the trigger was sent whose frame has not come
  double read_back_s{0.0};             ///< when a setting is read back next
  std::mutex order_mutex;
  std::vector<std::pair<std::string, std::string>> features;  ///< of the camera
  std::optional<ExposureOrder> exposure_order;
  std::atomic<bool> stop{false};
  std::thread thread;
};

AravisCamera::AravisCamera(const AravisSettings& settings)
    : exposure_{settings.exposure_s, settings.gain_db}, impl_(std::make_unique<Impl>(settings)) {}
AravisCamera::~AravisCamera() = default;

cv::Size AravisCamera::sensor_size_px() const {
  return impl_->settings.sensor_px;
}

void AravisCamera::set_region(const cv::Rect& region_px) {
  require_region(region_px, sensor_size_px());
  const bool restarts = region_px.size() != impl_->mailbox.region().size();
  impl_->mailbox.ask_region(region_px);
  if (restarts) next_frame();  // the first frame shows that the camera is watched again
}

FrameResult AravisCamera::next_frame() {
  return impl_->mailbox.next(impl_->patience_s());
}

FrameResult AravisCamera::following_frame() {
  return impl_->mailbox.following(impl_->patience_s());
}

std::optional<std::string> AravisCamera::fault() const {
  return impl_->mailbox.fault();
}

FrameCounts AravisCamera::counts() const {
  return impl_->mailbox.counts();
}

std::vector<std::pair<std::string, std::string>> AravisCamera::features() const {
  const std::lock_guard<std::mutex> lock(impl_->order_mutex);
  return impl_->features;
}

void AravisCamera::set_exposure(const CameraExposure& exposure) {
  require_exposure(exposure);
  const double frame_rate_hz = impl_->settings.frame_rate_hz;
  if (exposure.time_s * frame_rate_hz >= 1.0)
    throw InputError(exposure_too_long(exposure.time_s, frame_rate_hz));
  std::future<void> done = impl_->order(exposure);
  if (done.wait_for(std::chrono::duration<double>(kOrderTime_s)) != std::future_status::ready) {
    impl_->withdraw_order();
    throw WorkError("the camera has not set the exposure: it does not answer", Cause::kDevice);
  }
  done.get();
  exposure_ = exposure;
}

}  // namespace planar
