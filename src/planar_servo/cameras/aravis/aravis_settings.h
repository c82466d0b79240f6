#pragma once

#include <opencv2/core/types.hpp>
#include <string>

namespace planar {

enum class CameraTrigger {
  kFreeRun,   ///< the camera exposes at its frame rate
  kSoftware,  ///< a command starts each exposure
  kHardware,  ///< an input line starts each exposure
};

/// A camera on GigE Vision or USB3 Vision and the features it shall have, applied at every opening.
struct AravisSettings {
  std::string address;  ///< of a GigE camera; empty: a USB camera
  std::string id;       ///< serial number; empty: whichever answers, or the first USB camera
  cv::Size sensor_px;
  double frame_rate_hz{0.0};  ///< the least rate at which frames come: it watches over the camera
  double exposure_s{0.0};
  double gain_db{0.0};
  std::string pixel_format{"Mono8"};  ///< of pixel_format_names()
  CameraTrigger trigger{CameraTrigger::kFreeRun};
  int packet_size{0};  ///< of GigE, bytes; 0: the largest that passes
  double timeout_s{0.5};
};

/// Throws InputError naming every setting that no camera can have.
void require_settings(const AravisSettings& settings);

/// In words.
std::string exposure_too_long(double exposure_s, double frame_rate_hz);

}  // namespace planar
