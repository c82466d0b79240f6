#include "planar_servo/cameras/aravis/aravis_kind.h"

#include "planar_servo/cameras/aravis/aravis_camera.h"
#include "planar_servo/cameras/aravis/aravis_doctor.h"
#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

constexpr int kMaxPacketSize = 65535;

constexpr Named<CameraTrigger> kTriggers[] = {{CameraTrigger::kFreeRun, "free_run"},
                                              {CameraTrigger::kSoftware, "software"},
                                              {CameraTrigger::kHardware, "hardware"}};

struct AravisDetails final : DeviceDetails {
  AravisSettings settings;  ///< but for what every camera has
};

}  // namespace

std::shared_ptr<const DeviceDetails> AravisKind::read(Fields& camera) const {
  auto details = std::make_shared<AravisDetails>();
  AravisSettings& settings = details->settings;
  if (camera.given("address", true)) camera.text("address", settings.address);
  if (camera.given("id", true)) camera.text("id", settings.id);
  camera.number("exposure_us", settings.exposure_s, kMicrosecond, Range::positive());
  camera.number("gain_db", settings.gain_db);
  camera.choice("pixel_format", settings.pixel_format, pixel_format_names());
  camera.choice("trigger", settings.trigger, kTriggers);
  if (camera.given("packet_size", true))
    camera.whole_number("packet_size", settings.packet_size, 0, kMaxPacketSize);
  return details;
}

AravisSettings aravis_settings(const CameraSettings& camera) {
  AravisSettings settings = static_cast<const AravisDetails&>(*camera.details).settings;
  settings.sensor_px = {camera.width_px, camera.height_px};
  settings.frame_rate_hz = camera.frame_rate_hz;
  settings.timeout_s = camera.timeout_s;
  return settings;
}

std::shared_ptr<FrameSource> AravisKind::open(const CellSettings& cell,
                                              const std::shared_ptr<VirtualCell>& /*world*/) const {
  return std::make_shared<AravisCamera>(aravis_settings(cell.camera));
}

std::vector<Finding> AravisKind::examine(const CellSettings& cell) const {
  const AravisSettings settings = aravis_settings(cell.camera);
  std::vector<Finding> findings = examine_camera(cell.camera, settings);
  if (settings.address.empty()) findings.push_back(examine_usb_memory());
  return findings;
}

}  // namespace planar
