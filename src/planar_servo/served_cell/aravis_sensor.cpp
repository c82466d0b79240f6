#include "planar_servo/served_cell/aravis_sensor.h"

#include <cmath>
#include <cstring>

namespace planar {
namespace {

// The rate at which the fake camera looks for software triggers. Its default of 25 Hz would cost 40
// ms a frame.
constexpr double kTriggerFrequency_hz = 1000.0;

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

}  // namespace planar
