#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/core/error.h"

namespace planar {

/// Holds what a camera did when it was opened and sent full frames for a moment.
struct CameraInspection {
  std::optional<Refusal> refusal;  ///< why it cannot be used; the rest is empty then
  std::size_t frame_bytes{0};      ///< of a full frame
  int packet_size{0};              ///< of GigE, bytes; 0 on USB
  double duration_s{0.0};
  int complete{0};
  int incomplete{0};
  std::uint64_t underruns{0};  ///< frames for which this machine had no memory free
};

/// Opens the camera with all settings, as a run would, and lets it send frames. Throws InputError
/// for settings that no camera can have.
CameraInspection inspect_camera(const AravisSettings& settings, double duration_s);

}  // namespace planar
