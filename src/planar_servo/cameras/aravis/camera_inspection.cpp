#include "planar_servo/cameras/aravis/camera_inspection.h"

#include "planar_servo/cameras/aravis/aravis_link.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr int kCameraBlocks = 6;  // the number that AravisCamera has
constexpr double kTestLateness_s = 0.1;

/// What mends a refusal of a camera that answers.
constexpr char kCorrectSettings[] =
    "correct the settings of `camera` in the cell file to what this camera is and can do";

void grab(AravisLink& link, const AravisSettings& settings, CameraInspection& inspection) {
  SteadyClock clock;
  const double period_s = 1.0 / settings.frame_rate_hz;
  const bool commands = settings.trigger == CameraTrigger::kSoftware;
  const double start_s = clock.now_s();
  double next_s = start_s;
  while (clock.now_s() < start_s + inspection.duration_s) {
    if (commands) {
      clock.sleep_for_s(next_s - clock.now_s());
      next_s = clock.now_s() + period_s;
      link.trigger();
    }
    const auto arrival = link.receive(settings.exposure_s + 2.0 * period_s + kTestLateness_s);
    if (arrival) ++(arrival->complete ? inspection.complete : inspection.incomplete);
  }
}

}  // namespace

CameraInspection inspect_camera(const AravisSettings& settings, double duration_s) {
  require_settings(settings);
  CameraInspection inspection;
  inspection.duration_s = duration_s;
  const auto pixels = static_cast<std::size_t>(settings.sensor_px.area());
  try {
    FrameMemory memory(kCameraBlocks, bytes_of(pixel_format_named(settings.pixel_format), pixels));
    AravisLink link(settings, memory);
    link.start({cv::Point(), settings.sensor_px});
    grab(link, settings, inspection);
    inspection.frame_bytes = link.frame_bytes();
    inspection.packet_size = link.packet_size();
    inspection.underruns = link.underruns();
  } catch (const WorkError& error) {
    inspection = {};
    inspection.refusal = error.refusal();
    if (inspection.refusal->remedy.empty()) inspection.refusal->remedy = kCorrectSettings;
  }
  return inspection;
}

}  // namespace planar
