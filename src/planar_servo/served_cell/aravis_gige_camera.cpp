#include "planar_servo/served_cell/aravis_gige_camera.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/served_cell/aravis_sensor.h"

namespace planar {

struct GigeCamera::Impl {
  explicit Impl(Exposure taken) : exposure(std::move(taken)) {}
  ~Impl() {
    if (server != nullptr) g_object_unref(server);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Exposure exposure;
  ArvGvFakeCamera* server{nullptr};
};

GigeCamera::GigeCamera(const std::string& address, const std::string& serial,
                       const cv::Size& sensor_px, double frame_rate_hz, Exposure exposure)
    : impl_(std::make_unique<Impl>(std::move(exposure))) {
  impl_->server = arv_gv_fake_camera_new(address.c_str(), serial.c_str());
  if (!arv_gv_fake_camera_is_running(impl_->server))
    throw WorkError(
        fmt::format("{}: no GigE camera can be served at this address; it is not an address of "
                    "this machine, or another camera has its port 3956",
                    address));
  show_on(arv_gv_fake_camera_get_fake_camera(impl_->server), impl_->exposure, sensor_px,
          frame_rate_hz);
}

GigeCamera::~GigeCamera() = default;

void GigeCamera::lose_packets(double share) {
  g_object_set(impl_->server, "gvsp-lost-ratio", share, nullptr);
}

}  // namespace planar
