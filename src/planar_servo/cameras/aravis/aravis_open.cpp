#include "planar_servo/cameras/aravis/aravis_open.h"

#include <fmt/format.h>

#include "planar_servo/cameras/aravis/camera_path.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

/// A camera obeys one program at a time. It waits so long, by the standard's default [GigE Vision
/// 2.0, GevHeartbeatTimeout], for a sign of life of one that ended without taking leave; seconds.
constexpr double kLeave_s = 3.0;
constexpr double kPatience_s = kLeave_s + 1.0, kPoll_s = 0.2;

void take_control(ArvDevice* device, const std::string& address) {
  SteadyClock clock;
  const double end_s = clock.now_s() + kPatience_s;
  while (arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == FALSE) {
    if (clock.now_s() > end_s)
      throw WorkError(Refusal{"another program controls the GigE camera at " + address,
                              "end that program; a camera obeys one at a time"});
    clock.sleep_for_s(kPoll_s);
    GError* refusal = nullptr;
    arv_gv_device_take_control(ARV_GV_DEVICE(device), &refusal);
    g_clear_error(&refusal);
  }
}

GObjectPtr<ArvDevice> reach_gige(const std::string& address) {
  const std::string local = local_address_towards(address);
  const GObjectPtr<GInetAddress> ours(g_inet_address_new_from_string(local.c_str()));
  const GObjectPtr<GInetAddress> theirs(g_inet_address_new_from_string(address.c_str()));
  try {
    return GObjectPtr<ArvDevice>(ask("no GigE camera answers at " + address, [&](GError** e) {
      return arv_gv_device_new(ours.get(), theirs.get(), e);
    }));
  } catch (const WorkError& error) {
    throw WorkError(
        Refusal{error.what(), fmt::format("ping {0}; if nothing answers, check that the camera "
                                          "has power and that this machine has an address in its "
                                          "network (ip route get {0})",
                                          address)});
  }
}

}  // namespace

GObjectPtr<ArvCamera> open_gige(const std::string& address) {
  const GObjectPtr<ArvDevice> device = reach_gige(address);
  take_control(device.get(), address);
  return GObjectPtr<ArvCamera>(
      ask("the GigE camera at " + address + " does not open",
          [&](GError** e) { return arv_camera_new_with_device(device.get(), e); }));
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
  throw WorkError(Refusal{fmt::format("no USB camera{} is plugged in{}",
                                      serial.empty() ? "" : " with the serial number " + serial,
                                      present.empty() ? "" : " (there are: " + present + ")"),
                          "check the camera's cable and power; lsusb -t shows what is plugged in"});
}

}  // namespace planar
