#include "planar_servo/machine/rehearsal/gige_camera.h"

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

constexpr int kControlPort = 3956;
// The rate at which the fake camera looks for software triggers. Its default of 25 Hz would cost 40
// ms a frame.
constexpr double kTriggerFrequency_hz = 1000.0;

/// Aravis' fake cameras share a port without a word, and each answers for the other.
bool is_free(const std::string& address) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(kControlPort);
  if (inet_pton(AF_INET, address.c_str(), &place.sin_addr) != 1) return false;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const bool is_bound = bind(probe, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0;
  close(probe);
  return is_bound;
}

void fill(ArvBuffer* buffer, void* exposure, guint32 exposure_us, guint32 gain_db,
          ArvPixelFormat format) {
  if (format != ARV_PIXEL_FORMAT_MONO_8) return;
  cv::Rect region;
  arv_buffer_get_image_region(buffer, &region.x, &region.y, &region.width, &region.height);
  const double brightness = exposure_us / static_cast<double>(kUsualExposure_us) *
                            std::pow(10.0, static_cast<double>(gain_db) / 20.0);
  const cv::Mat image = (*static_cast<const Exposure*>(exposure))(region, brightness);
  std::size_t ignored = 0;  // reads as 0 while the buffer is being filled
  void* const data = const_cast<void*>(arv_buffer_get_data(buffer, &ignored));
  std::memcpy(data, image.data, image.total());
}

}  // namespace

void show_on(ArvFakeCamera* camera, const Exposure& exposure, const cv::Size& sensor_px,
             double frame_rate_hz) {
  const auto set = [&](guint32 address, int value) {
    arv_fake_camera_write_register(camera, address, static_cast<guint32>(value));
  };
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, sensor_px.width);
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, sensor_px.height);
  set(ARV_FAKE_CAMERA_REGISTER_WIDTH, sensor_px.width);
  set(ARV_FAKE_CAMERA_REGISTER_HEIGHT, sensor_px.height);
  set(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US, static_cast<int>(kUsualExposure_us));
  set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
      static_cast<int>(std::lround(1e6 / frame_rate_hz)));
  arv_fake_camera_set_trigger_frequency(camera, kTriggerFrequency_hz);
  arv_fake_camera_set_fill_pattern(camera, fill, const_cast<Exposure*>(&exposure));
}

GigeCamera::GigeCamera(const std::string& address, const std::string& serial,
                       const cv::Size& sensor_px, double frame_rate_hz, Exposure exposure)
    : exposure_(std::move(exposure)), server_(nullptr, g_object_unref) {
  const bool can_run = is_free(address);
  if (can_run) server_.reset(arv_gv_fake_camera_new(address.c_str(), serial.c_str()));
  if (!can_run || !arv_gv_fake_camera_is_running(server_.get()))
    throw WorkError(
        fmt::format(
            "{0}: no GigE camera can be served at this address; no interface of this machine "
            "has it (sudo ip address add {0}/8 dev lo), or another camera has its port {1}",
            address, kControlPort),
        Cause::kSystem);
  show_on(arv_gv_fake_camera_get_fake_camera(server_.get()), exposure_, sensor_px, frame_rate_hz);
}

void GigeCamera::lose_packets(double share) {
  g_object_set(server_.get(), "gvsp-lost-ratio", share, nullptr);
}

}  // namespace planar
