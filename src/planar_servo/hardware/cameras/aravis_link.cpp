#include "planar_servo/hardware/cameras/aravis_link.h"

#include <arv.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cameras/aravis_setup.h"

namespace planar {
namespace {

// Crystals are good to 100 ppm, and a steady clock that is being adjusted may be off by 500 ppm.
constexpr double kDrift = 600e-6;

constexpr std::size_t kPageBytes = 4096;
constexpr guint kFrameRetention_us = 50000;  ///< packets later than this count as lost

/// Converts a time of day, which Aravis stamps on frames, to the steady clock.
double steady_s(guint64 time_of_day_ns) {
  const double ago_s =
      1e-6 * static_cast<double>(g_get_real_time()) - 1e-9 * static_cast<double>(time_of_day_ns);
  return SteadyClock().now_s() - std::max(0.0, ago_s);
}

/// Widens [start, start + size) to the camera's raster of `start_step` and `size_step` within the
/// sensor.
void fit_to_raster(int& start, int& size, int start_step, int size_step, int sensor) {
  const int end = start + size;
  start -= start % std::max(start_step, 1);
  size_step = std::max(size_step, 1);
  size = std::min((end - start + size_step - 1) / size_step * size_step, sensor);
  if (start + size > sensor) start = (sensor - size) / std::max(start_step, 1) * start_step;
}

}  // namespace

void CameraClock::begin_stream(double start_s) {
  start_s_ = start_s;
}

double CameraClock::due_s(double device_s, double arrival_s) {
  if (!std::isfinite(device_s) || !std::isfinite(arrival_s))
    throw std::invalid_argument("CameraClock::due_s: a time is not finite");
  const double offset_s = arrival_s - device_s;
  const bool advances = last_device_s_ && device_s > *last_device_s_;
  offset_s_ =
      advances ? std::min(offset_s, offset_s_ + kDrift * (device_s - *last_device_s_)) : offset_s;
  last_device_s_ = device_s;
  const double due_s = std::min(device_s + offset_s_, arrival_s);
  const auto start_s = std::exchange(start_s_, std::nullopt);
  if (start_s && due_s < *start_s) believed_ = false;
  return believed_ ? due_s : arrival_s;
}

FrameMemory::FrameMemory(const AravisSettings& settings) {
  constexpr int kBlocks = 6;  // two are being filled, two compared, two are spare
  const std::size_t largest =
      bytes_of(settings.pixel_format, static_cast<std::size_t>(settings.sensor_px.area()));
  bytes_ = (largest + kPageBytes - 1) / kPageBytes * kPageBytes;
  for (int i = 0; i < kBlocks; ++i) {
    blocks_.emplace_back(static_cast<std::uint8_t*>(std::aligned_alloc(kPageBytes, bytes_)),
                         std::free);
    if (!blocks_.back())
      throw WorkError("there is no memory for the camera's frames", Cause::kSystem);
  }
}

struct AravisLink::Impl {
  Impl(const AravisSettings& wanted, FrameMemory& frames) : settings(wanted), memory(frames) {
    camera = settings.address.empty() ? open_usb(settings.id) : open_gige(settings.address);
    made_plain = make_plain(camera.get());
    for (const std::string& change : made_plain) spdlog::debug("the camera's " + change);
    require_identity(camera.get(), settings);
    apply_settings(camera.get(), settings);
    features = picture_features(camera.get());
    read_raster();
    control_lost = g_signal_connect(arv_camera_get_device(camera.get()), "control-lost",
                                    G_CALLBACK(&Impl::on_control_lost), &lost);
  }

  ~Impl() {
    g_signal_handler_disconnect(arv_camera_get_device(camera.get()), control_lost);
    if (streaming && !lost) {
      GError* ignored = nullptr;  // closing the connection stops the camera, too
      arv_camera_stop_acquisition(camera.get(), &ignored);
      g_clear_error(&ignored);
    }
    release_buffers();
  }

  static void on_control_lost(ArvDevice* /*device*/, gpointer flag) {
    static_cast<std::atomic<bool>*>(flag)->store(true);
  }

  void read_raster() {
    const auto step = [&](gint (*increment)(ArvCamera*, GError**)) {
      return ask("the camera does not report the steps in which its region can be set",
                 [&](GError** e) { return increment(camera.get(), e); });
    };
    raster_px = {step(arv_camera_get_x_offset_increment), step(arv_camera_get_y_offset_increment),
                 step(arv_camera_get_width_increment), step(arv_camera_get_height_increment)};
  }

  cv::Rect fitted(cv::Rect region_px) const {
    fit_to_raster(region_px.x, region_px.width, raster_px.x, raster_px.width,
                  settings.sensor_px.width);
    fit_to_raster(region_px.y, region_px.height, raster_px.y, raster_px.height,
                  settings.sensor_px.height);
    return region_px;
  }

  void stop_stream() {
    if (!streaming) return;
    ask("the camera does not stop",
        [&](GError** e) { arv_camera_stop_acquisition(camera.get(), e); });
    streaming = false;
    release_buffers();
  }

  /// Frees the stream, so that Aravis no longer uses the memory.
  void release_buffers() {
    last.reset();
    stream.reset();
  }

  std::size_t frame_bytes() const {
    return ask("the camera does not report its frame size",
               [&](GError** e) { return arv_camera_get_payload(camera.get(), e); });
  }

  void create_stream() {
    stream.reset(ask("the camera does not stream", [&](GError** e) {
      return arv_camera_create_stream(camera.get(), nullptr, nullptr, e);
    }));
    if (arv_camera_is_gv_device(camera.get()))
      g_object_set(stream.get(), "frame-retention", kFrameRetention_us, nullptr);
    const std::size_t payload = frame_bytes();
    if (payload > memory.bytes())
      throw WorkError(
          {fmt::format("the camera's frames have {} bytes, but at most {} were expected", payload,
                       memory.bytes()),
           "see which of its settings adds data to its frames", "", Cause::kDevice});
    for (const FrameMemory::Block& block : memory.blocks())
      arv_stream_push_buffer(stream.get(), arv_buffer_new(payload, block.get()));
  }

  bool repeats_last(ArvBuffer* buffer, const Arrival& arrival) {
    if (!last || arv_buffer_get_image_width(last.get()) != arrival.region_px.width ||
        arv_buffer_get_image_height(last.get()) != arrival.region_px.height)
      return false;
    std::size_t size = 0, last_size = 0;
    const void* data = arv_buffer_get_image_data(buffer, &size);
    const void* last_data = arv_buffer_get_image_data(last.get(), &last_size);
    return size == last_size && std::memcmp(data, last_data, size) == 0;
  }

  Arrival judge(ArvBuffer* buffer) {
    Arrival arrival;
    if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS ||
        arv_buffer_get_payload_type(buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE ||
        arv_buffer_get_image_pixel_format(buffer) != arv_format(settings.pixel_format))
      return arrival;
    cv::Rect& region = arrival.region_px;
    arv_buffer_get_image_region(buffer, &region.x, &region.y, &region.width, &region.height);
    std::size_t size = 0;
    arrival.data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    arrival.id = arv_buffer_get_frame_id(buffer);
    arrival.complete =
        region.area() > 0 &&
        size >= bytes_of(settings.pixel_format, static_cast<std::size_t>(region.area()));
    arrival.repeated = arrival.complete && repeats_last(buffer, arrival);
    if (arrival.complete) date(buffer, arrival);
    return arrival;
  }

  void date(ArvBuffer* buffer, Arrival& arrival) {
    const bool believed = clock.believed();
    const double arrival_s = steady_s(arv_buffer_get_system_timestamp(buffer));
    const double device_s = 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
    arrival.due_s = clock.due_s(device_s, arrival_s);
    arrival.late_s = arrival_s - arrival.due_s;
    if (believed && !clock.believed())
      spdlog::warn(
          "the camera's clock runs slow; from now on its frames are dated by their arrival");
  }

  AravisSettings settings;
  FrameMemory& memory;
  CameraClock clock;
  cv::Rect raster_px;  ///< increments of a region's position and size
  GObjectPtr<ArvCamera> camera;
  std::vector<std::string> made_plain;
  std::vector<CameraFeature> features;
  std::size_t next_feature{0};  ///< to be read back
  GObjectPtr<ArvStream> stream;
  GObjectPtr<ArvBuffer> last;  ///< the newest complete frame, not yet given back
  gulong control_lost{0};
  std::atomic<bool> lost{false};
  bool streaming{false};
};

AravisLink::AravisLink(const AravisSettings& settings, FrameMemory& memory)
    : impl_(std::make_unique<Impl>(settings, memory)) {}
AravisLink::~AravisLink() = default;

void AravisLink::start(const cv::Rect& region_px) {
  impl_->stop_stream();
  const cv::Rect fitted = impl_->fitted(region_px);
  ask("the camera refuses the region", [&](GError** e) {
    arv_camera_set_region(impl_->camera.get(), fitted.x, fitted.y, fitted.width, fitted.height, e);
  });
  impl_->create_stream();
  impl_->clock.begin_stream(SteadyClock().now_s());
  ask("the camera does not start",
      [&](GError** e) { arv_camera_start_acquisition(impl_->camera.get(), e); });
  impl_->streaming = true;
  spdlog::debug(fmt::format("the camera streams {} x {} px at ({}, {}), {} bytes a frame",
                            fitted.width, fitted.height, fitted.x, fitted.y, impl_->frame_bytes()));
}

void AravisLink::move(const cv::Rect& region_px) {
  const cv::Rect fitted = impl_->fitted(region_px);
  ArvDevice* const device = arv_camera_get_device(impl_->camera.get());
  const auto set = [&](const char* feature, int value) {
    ask("the camera does not move its region while it streams",
        [&](GError** e) { arv_device_set_integer_feature_value(device, feature, value, e); });
  };
  set("OffsetX", fitted.x);
  set("OffsetY", fitted.y);
}

void AravisLink::expose(const CameraExposure& exposure) {
  apply_exposure(impl_->camera.get(), exposure);
  impl_->features = picture_features(impl_->camera.get());
}

void AravisLink::light(bool on) {
  apply_strobe(impl_->camera.get(), impl_->settings.strobe.value(), on);
}

const std::vector<CameraFeature>& AravisLink::features() const {
  return impl_->features;
}

void AravisLink::require_unchanged() {
  if (impl_->features.empty()) return;
  impl_->next_feature = (impl_->next_feature + 1) % impl_->features.size();
  planar::require_unchanged(impl_->camera.get(), impl_->features[impl_->next_feature]);
}

void AravisLink::trigger() {
  ask("the camera refuses a trigger",
      [&](GError** e) { arv_camera_software_trigger(impl_->camera.get(), e); });
}

std::optional<AravisLink::Arrival> AravisLink::receive(double timeout_s) {
  const auto timeout_us = static_cast<guint64>(std::llround(1e6 * timeout_s));
  ArvBuffer* const buffer = arv_stream_timeout_pop_buffer(impl_->stream.get(), timeout_us);
  if (buffer == nullptr) return std::nullopt;
  const Arrival arrival = impl_->judge(buffer);
  if (!arrival.complete) {
    arv_stream_push_buffer(impl_->stream.get(), buffer);
    return arrival;
  }
  if (impl_->last) arv_stream_push_buffer(impl_->stream.get(), impl_->last.release());
  impl_->last.reset(buffer);
  return arrival;
}

const std::string& AravisLink::id() const {
  return impl_->settings.id;
}

std::string AravisLink::identity() const {
  return identity_of(impl_->camera.get());
}

const std::vector<std::string>& AravisLink::made_plain() const {
  return impl_->made_plain;
}

bool AravisLink::lost() const {
  return impl_->lost;
}

std::size_t AravisLink::frame_bytes() const {
  return impl_->frame_bytes();
}

int AravisLink::packet_size() const {
  if (!arv_camera_is_gv_device(impl_->camera.get())) return 0;
  return static_cast<int>(ask("the camera does not report its packet size", [&](GError** e) {
    return arv_camera_gv_get_packet_size(impl_->camera.get(), e);
  }));
}

std::uint64_t AravisLink::underruns() const {
  guint64 complete = 0, failed = 0, underruns = 0;
  arv_stream_get_statistics(impl_->stream.get(), &complete, &failed, &underruns);
  return underruns;
}

}  // namespace planar
