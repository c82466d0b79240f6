#pragma once

#include <opencv2/core/types.hpp>
#include <string>

namespace planar {

enum class CameraTrigger {
  kFreeRun,   ///< the camera exposes at its frame rate
  kSoftware,  ///< a command starts each exposure
  kHardware,  ///< an input line starts each exposure
};

/// Settings of a GigE Vision or USB3 Vision camera, applied at every opening.
struct AravisSettings {
  std::string address;  ///< of a GigE camera; empty for USB
  std::string id;       ///< serial number; empty for the first that answers
  cv::Size sensor_px;
  double frame_rate_hz{0.0};  ///< frames come at least at this rate, else the camera is at fault
  double exposure_s{0.0};
  double gain_db{0.0};
  std::string pixel_format{"Mono8"};  ///< one of pixel_format_names()
  CameraTrigger trigger{CameraTrigger::kFreeRun};
  int packet_size{0};  ///< bytes of a GigE packet; 0 for the largest that passes
  double timeout_s{0.5};
};

/// Throws InputError naming every setting that no camera can have.
void require_settings(const AravisSettings& settings);

/// Returns a message that says why this exposure time does not fit the frame rate.
std::string exposure_too_long(double exposure_s, double frame_rate_hz);

}  // namespace planar
