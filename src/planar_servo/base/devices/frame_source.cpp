#include "planar_servo/base/devices/frame_source.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"

namespace planar {

const char* name(FrameStatus status) {
  constexpr Named<FrameStatus> kFrameStatuses[] = {{FrameStatus::kOk, "ok"},
                                                   {FrameStatus::kTimeout, "no_frame"},
                                                   {FrameStatus::kIncomplete, "incomplete_frame"},
                                                   {FrameStatus::kFrozen, "frozen_frame"},
                                                   {FrameStatus::kLost, "camera_lost"}};
  return name_in(kFrameStatuses, status);
}

FrameCounts operator-(const FrameCounts& now, const FrameCounts& before) {
  return {now.complete - before.complete, now.incomplete - before.incomplete,
          now.frozen - before.frozen, now.reopened - before.reopened};
}

std::string describe(const FrameCounts& counts) {
  return fmt::format(
      "{} whole frames; left out: {} with parts missing, {} repeated; the camera was lost and "
      "found {} time{}",
      counts.complete, counts.incomplete, counts.frozen, counts.reopened,
      counts.reopened == 1 ? "" : "s");
}

void require_exposure(const CameraExposure& exposure) {
  if (!(exposure.time_s > 0.0) || !std::isfinite(exposure.time_s) ||
      !std::isfinite(exposure.gain_db))
    throw InputError("an exposure needs a positive, finite time and a finite gain");
}

void require_region(const cv::Rect& region_px, const cv::Size& sensor_px) {
  if (region_px.empty() || (region_px & cv::Rect(cv::Point(), sensor_px)) != region_px)
    throw std::invalid_argument("a camera's region must not be empty or leave the sensor");
}

}  // namespace planar
