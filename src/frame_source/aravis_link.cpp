#include "frame_source/aravis_link.h"

#include <arv.h>
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>

#include "core/clock.h"
#include "core/error.h"
#include "frame_source/camera_path.h"

namespace planar {
namespace {

constexpr std::size_t kPageBytes = 4096;
constexpr guint kFrameRetention_us = 50000;  ///< packets later than this count as lost

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <typename T>
using GObjectPtr = std::unique_ptr<T, Unref>;

/// Makes a call that reports by GError; its failure is a WorkError that begins with `what`.
template <typename Call>
auto ask(const std::string& what, Call call) {
  GError* error = nullptr;
  const auto refuse = [&] {
    if (error == nullptr) return;
    const std::string message = error->message;
    g_error_free(error);
    throw WorkError(what + ": " + message);
  };
  if constexpr (std::is_void_v<decltype(call(&error))>) {
    call(&error);
    refuse();
  } else {
    const auto answer = call(&error);
    refuse();
    return answer;
  }
}

GObjectPtr<ArvCamera> open_gige(const std::string& address) {
  const std::string local = local_address_towards(address);
  const GObjectPtr<GInetAddress> ours(g_inet_address_new_from_string(local.c_str()));
  const GObjectPtr<GInetAddress> theirs(g_inet_address_new_from_string(address.c_str()));
  const std::string what = "no GigE camera answers at " + address;
  try {
    const GObjectPtr<ArvDevice> device(
        ask(what, [&](GError** e) { return arv_gv_device_new(ours.get(), theirs.get(), e); }));
    return GObjectPtr<ArvCamera>(
        ask(what, [&](GError** e) { return arv_camera_new_with_device(device.get(), e); }));
  } catch (const WorkError& error) {
    throw CameraAbsent(error.what());
  }
}

GObjectPtr<ArvCamera> open_usb(const std::string& serial) {
  for (const char* other : {"GigEVision", "Fake"}) arv_disable_interface(other);
  arv_update_device_list();
  std::string present;
  for (unsigned int i = 0; i < arv_get_n_devices(); ++i) {
    const std::string found = arv_get_device_serial_nbr(i);
    present += (present.empty() ? "" : ", ") + found;
    if (!serial.empty() && found != serial) continue;
    const char* device = arv_get_device_id(i);
    return GObjectPtr<ArvCamera>(ask("the USB camera " + found + " does not open",
                                     [&](GError** e) { return arv_camera_new(device, e); }));
  }
  throw CameraAbsent(
      fmt::format("no USB camera{} is there ({}); check its cable and, with "
                  "planar-doctor, the permission to use it",
                  serial.empty() ? "" : " with the serial number " + serial,
                  present.empty() ? "none at all" : "there are: " + present));
}

ArvPixelFormat arv_format(PixelFormat format) {
  switch (format) {
    case PixelFormat::kMono8:
      return ARV_PIXEL_FORMAT_MONO_8;
    case PixelFormat::kMono10:
      return ARV_PIXEL_FORMAT_MONO_10;
    case PixelFormat::kMono10p:
      return 0x010a0046;  // of the convention; Aravis has no name for it
    case PixelFormat::kMono10Packed:
      return ARV_PIXEL_FORMAT_MONO_10_PACKED;
    case PixelFormat::kMono12:
      return ARV_PIXEL_FORMAT_MONO_12;
    case PixelFormat::kMono12p:
      return 0x010c0047;
    case PixelFormat::kMono12Packed:
      return ARV_PIXEL_FORMAT_MONO_12_PACKED;
  }
  throw std::invalid_argument("unknown PixelFormat");
}

/// An input line that can start an exposure.
std::string hardware_trigger(ArvCamera* camera) {
  guint n = 0;
  const std::unique_ptr<const char*, void (*)(gpointer)> sources(
      ask("the camera does not name its trigger sources",
          [&](GError** e) { return arv_camera_dup_available_trigger_sources(camera, &n, e); }),
      g_free);
  for (guint i = 0; i < n; ++i) {
    std::string source = sources.get()[i];
    if (source.rfind("Line", 0) == 0) return source;
  }
  throw WorkError("the camera has no input line that could trigger it");
}

/// The steady clock's time of a moment that Aravis stamped with the time of day.
double steady_s(guint64 time_of_day_ns) {
  const double ago_s =
      1e-6 * static_cast<double>(g_get_real_time()) - 1e-9 * static_cast<double>(time_of_day_ns);
  return SteadyClock().now_s() - std::max(0.0, ago_s);
}

/// `start` and `size` on a raster of `step` that holds [start, start + size) within the sensor.
void fit_to_raster(int& start, int& size, int start_step, int size_step, int sensor) {
  const int end = start + size;
  start -= start % std::max(start_step, 1);
  size_step = std::max(size_step, 1);
  size = std::min((end - start + size_step - 1) / size_step * size_step, sensor);
  if (start + size > sensor) start = (sensor - size) / std::max(start_step, 1) * start_step;
}

}  // namespace

void FrameMemory::Free::operator()(std::uint8_t* block) const {
  std::free(block);
}

FrameMemory::FrameMemory(int blocks, std::size_t bytes)
    : bytes_((bytes + kPageBytes - 1) / kPageBytes * kPageBytes) {
  for (int i = 0; i < blocks; ++i) {
    blocks_.emplace_back(static_cast<std::uint8_t*>(std::aligned_alloc(kPageBytes, bytes_)));
    if (!blocks_.back()) throw WorkError("there is no memory for the camera's frames");
  }
}

struct AravisLink::Impl {
  Impl(const AravisSettings& wanted, FrameMemory& frames)
      : settings(wanted), format(pixel_format_named(wanted.pixel_format)), memory(frames) {
    camera = settings.address.empty() ? open_usb(settings.id) : open_gige(settings.address);
    check_identity();
    apply_features();
    apply_trigger();
    if (arv_camera_is_gv_device(camera.get())) apply_packet_size();
    read_raster();
    control_lost = g_signal_connect(arv_camera_get_device(camera.get()), "control-lost",
                                    G_CALLBACK(&Impl::on_control_lost), &lost);
  }

  ~Impl() {
    g_signal_handler_disconnect(arv_camera_get_device(camera.get()), control_lost);
    if (streaming && !lost) {
      GError* ignored = nullptr;  // the camera stops sending when its connection closes, too
      arv_camera_stop_acquisition(camera.get(), &ignored);
      g_clear_error(&ignored);
    }
    release_buffers();
  }

  static void on_control_lost(ArvDevice* /*device*/, gpointer flag) {
    static_cast<std::atomic<bool>*>(flag)->store(true);
  }

  void check_identity() {
    ArvCamera* const c = camera.get();
    if (!settings.id.empty()) {
      const std::string serial = ask("the camera does not tell its serial number", [&](GError** e) {
        return arv_camera_get_device_serial_number(c, e);
      });
      if (serial != settings.id)
        throw WorkError(
            fmt::format("the camera at {} is {}, not {}", settings.address, serial, settings.id));
    }
    cv::Size sensor;
    ask("the camera does not tell its size",
        [&](GError** e) { arv_camera_get_sensor_size(c, &sensor.width, &sensor.height, e); });
    if (sensor != settings.sensor_px)
      throw WorkError(fmt::format("the camera's sensor has {} x {} pixels; the cell says {} x {}",
                                  sensor.width, sensor.height, settings.sensor_px.width,
                                  settings.sensor_px.height));
  }

  void apply_features() {
    ArvCamera* const c = camera.get();
    ask("the camera refuses the pixel format " + settings.pixel_format,
        [&](GError** e) { arv_camera_set_pixel_format(c, arv_format(format), e); });
    const auto automatic_off = [&](const char* what, auto available, auto set) {
      if (!ask(what, [&](GError** e) { return available(c, e); })) return;
      ask(what, [&](GError** e) { set(c, ARV_AUTO_OFF, e); });
    };
    automatic_off("the camera keeps its exposure automatic", arv_camera_is_exposure_auto_available,
                  arv_camera_set_exposure_time_auto);
    automatic_off("the camera keeps its gain automatic", arv_camera_is_gain_auto_available,
                  arv_camera_set_gain_auto);
    expose({settings.exposure_s, settings.gain_db});
  }

  template <typename GetBounds>
  void require_within(const char* what, double value, const char* unit, GetBounds get_bounds) {
    double least = 0.0, most = 0.0;
    ask(fmt::format("the camera does not tell {}'s bounds", what),
        [&](GError** e) { get_bounds(camera.get(), &least, &most, e); });
    if (value < least || value > most)
      throw WorkError(
          fmt::format("the camera refuses {} of {:.6g} {}; it can do {:.6g} to {:.6g} {}", what,
                      value, unit, least, most, unit));
  }

  void expose(const CameraExposure& exposure) {
    ArvCamera* const c = camera.get();
    const double time_us = 1e6 * exposure.time_s;
    require_within("an exposure", time_us, "us", arv_camera_get_exposure_time_bounds);
    require_within("a gain", exposure.gain_db, "dB", arv_camera_get_gain_bounds);
    ask(fmt::format("the camera refuses an exposure of {:.0f} us", time_us),
        [&](GError** e) { arv_camera_set_exposure_time(c, time_us, e); });
    ask(fmt::format("the camera refuses a gain of {} dB", exposure.gain_db),
        [&](GError** e) { arv_camera_set_gain(c, exposure.gain_db, e); });
  }

  void apply_trigger() {
    ArvCamera* const c = camera.get();
    if (settings.trigger == CameraTrigger::kFreeRun) {
      ask("the camera does not run freely", [&](GError** e) { arv_camera_clear_triggers(c, e); });
      ask(fmt::format("the camera refuses {:.4g} frames/s", settings.frame_rate_hz),
          [&](GError** e) { arv_camera_set_frame_rate(c, settings.frame_rate_hz, e); });
      return;
    }
    const std::string source =
        settings.trigger == CameraTrigger::kSoftware ? "Software" : hardware_trigger(c);
    ask("the camera refuses the trigger " + source,
        [&](GError** e) { arv_camera_set_trigger(c, source.c_str(), e); });
  }

  void apply_packet_size() {
    if (settings.packet_size == 0) return;  // Aravis finds the largest that passes
    arv_camera_gv_set_packet_size_adjustment(camera.get(), ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    ask(fmt::format("the camera refuses packets of {} bytes", settings.packet_size),
        [&](GError** e) { arv_camera_gv_set_packet_size(camera.get(), settings.packet_size, e); });
  }

  void read_raster() {
    const auto step = [&](gint (*increment)(ArvCamera*, GError**)) {
      return ask("the camera does not tell its raster of regions",
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

  /// Takes the memory out of Aravis' hands.
  void release_buffers() {
    last.reset();
    stream.reset();
  }

  std::size_t frame_bytes() const {
    return ask("the camera does not tell the size of its frames",
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
          fmt::format("the camera's frames have {} bytes; {} were expected at most; "
                      "switch its chunk data off",
                      payload, memory.bytes()));
    for (int i = 0; i < memory.blocks(); ++i)
      arv_stream_push_buffer(stream.get(), arv_buffer_new(payload, memory.block(i)));
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
    arrival.t_s = steady_s(arv_buffer_get_system_timestamp(buffer));
    if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS ||
        arv_buffer_get_payload_type(buffer) != ARV_BUFFER_PAYLOAD_TYPE_IMAGE ||
        arv_buffer_get_image_pixel_format(buffer) != arv_format(format))
      return arrival;
    cv::Rect& region = arrival.region_px;
    arv_buffer_get_image_region(buffer, &region.x, &region.y, &region.width, &region.height);
    std::size_t size = 0;
    arrival.data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
    arrival.id = arv_buffer_get_frame_id(buffer);
    arrival.complete =
        region.area() > 0 && size >= bytes_of(format, static_cast<std::size_t>(region.area()));
    arrival.repeated = arrival.complete && repeats_last(buffer, arrival);
    return arrival;
  }

  AravisSettings settings;
  PixelFormat format;
  FrameMemory& memory;
  cv::Rect raster_px;  ///< steps of a region's place and size
  GObjectPtr<ArvCamera> camera;
  GObjectPtr<ArvStream> stream;
  GObjectPtr<ArvBuffer> last;  ///< the newest complete frame, not yet given back
  gulong control_lost{0};
  std::atomic<bool> lost{false};
  bool streaming{false};
};

AravisLink::AravisLink(const AravisSettings& settings, FrameMemory& memory)
    : impl_(std::make_unique<Impl>(settings, memory)) {}
AravisLink::~AravisLink() = default;

cv::Rect AravisLink::start(const cv::Rect& region_px) {
  impl_->stop_stream();
  const cv::Rect fitted = impl_->fitted(region_px);
  ask("the camera refuses the region", [&](GError** e) {
    arv_camera_set_region(impl_->camera.get(), fitted.x, fitted.y, fitted.width, fitted.height, e);
  });
  impl_->create_stream();
  ask("the camera does not start",
      [&](GError** e) { arv_camera_start_acquisition(impl_->camera.get(), e); });
  impl_->streaming = true;
  return fitted;
}

cv::Rect AravisLink::move(const cv::Rect& region_px) {
  const cv::Rect fitted = impl_->fitted(region_px);
  ArvDevice* const device = arv_camera_get_device(impl_->camera.get());
  const auto set = [&](const char* feature, int value) {
    ask("the camera does not move its region while it streams",
        [&](GError** e) { arv_device_set_integer_feature_value(device, feature, value, e); });
  };
  set("OffsetX", fitted.x);
  set("OffsetY", fitted.y);
  return fitted;
}

void AravisLink::expose(const CameraExposure& exposure) {
  impl_->expose(exposure);
}

void AravisLink::trigger() {
  ask("the camera takes no trigger",
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

bool AravisLink::lost() const {
  return impl_->lost;
}

std::size_t AravisLink::frame_bytes() const {
  return impl_->frame_bytes();
}

int AravisLink::packet_size() const {
  if (!arv_camera_is_gv_device(impl_->camera.get())) return 0;
  return static_cast<int>(ask("the camera does not tell the size of its packets", [&](GError** e) {
    return arv_camera_gv_get_packet_size(impl_->camera.get(), e);
  }));
}

std::uint64_t AravisLink::underruns() const {
  guint64 complete = 0, failed = 0, underruns = 0;
  arv_stream_get_statistics(impl_->stream.get(), &complete, &failed, &underruns);
  return underruns;
}

}  // namespace planar
