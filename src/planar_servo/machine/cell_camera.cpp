#include "planar_servo/machine/cell_camera.h"

#include <stdexcept>

#include "planar_servo/cameras/aravis/aravis_camera.h"

namespace planar {
namespace {

CameraTrigger trigger_named(const std::string& name) {
  if (name == "free_run") return CameraTrigger::kFreeRun;
  if (name == "software") return CameraTrigger::kSoftware;
  if (name == "hardware") return CameraTrigger::kHardware;
  throw std::invalid_argument("unknown trigger " + name);
}

}  // namespace

AravisSettings aravis_settings(const CellSettings& cell) {
  const CameraSettings& camera = cell.camera;
  const CameraConnection& connection = camera.connection;
  AravisSettings settings;
  settings.address = connection.address;
  settings.id = connection.id;
  settings.sensor_px = {camera.width_px, camera.height_px};
  settings.frame_rate_hz = camera.frame_rate_hz;
  settings.exposure_s = connection.exposure_s;
  settings.gain_db = connection.gain_db;
  settings.pixel_format = connection.pixel_format;
  settings.trigger = trigger_named(connection.trigger);
  settings.packet_size = connection.packet_size;
  settings.timeout_s = camera.timeout_s;
  return settings;
}

std::unique_ptr<FrameSource> open_camera(const CellSettings& cell) {
  return std::make_unique<AravisCamera>(aravis_settings(cell));
}

}  // namespace planar
