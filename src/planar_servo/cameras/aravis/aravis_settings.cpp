#include "planar_servo/cameras/aravis/aravis_settings.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"

namespace planar {

void require_settings(const AravisSettings& settings) {
  Faults faults;
  const auto require = [&](bool holds, const std::string& rule) {
    if (!holds) faults.add("camera settings: " + rule);
  };
  require(!settings.sensor_px.empty(), "the sensor needs pixels");
  require(settings.frame_rate_hz > 0.0, "the frame rate must be positive");
  require(settings.exposure_s > 0.0, "the exposure time must be positive");
  require(settings.exposure_s * settings.frame_rate_hz < 1.0,
          exposure_too_long(settings.exposure_s, settings.frame_rate_hz));
  require(settings.timeout_s > 0.0, "the timeout must be positive");
  faults.throw_if_any();
}

std::string exposure_too_long(double exposure_s, double frame_rate_hz) {
  return fmt::format("an exposure of {:.0f} us does not fit into a period at {:.3g} Hz",
                     1e6 * exposure_s, frame_rate_hz);
}

}  // namespace planar
