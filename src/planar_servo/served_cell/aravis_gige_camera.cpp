#include "planar_servo/served_cell/aravis_gige_camera.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "planar_servo/core/error.h"
#include "planar_servo/served_cell/aravis_sensor.h"

namespace planar {
namespace {

constexpr int kControlPort = 3956;

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

}  // namespace

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
  const bool can_run = is_free(address);
  if (can_run) impl_->server = arv_gv_fake_camera_new(address.c_str(), serial.c_str());
  if (!can_run || !arv_gv_fake_camera_is_running(impl_->server))
    throw WorkError(
        fmt::format("{}: no GigE camera can be served at this address; it is not an address of "
                    "this machine, or another camera has its port {}",
                    address, kControlPort));
  show_on(arv_gv_fake_camera_get_fake_camera(impl_->server), impl_->exposure, sensor_px,
          frame_rate_hz);
}

GigeCamera::~GigeCamera() = default;

void GigeCamera::lose_packets(double share) {
  g_object_set(impl_->server, "gvsp-lost-ratio", share, nullptr);
}

}  // namespace planar
