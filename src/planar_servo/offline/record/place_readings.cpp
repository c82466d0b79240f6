#include "planar_servo/offline/record/place_readings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace planar {
namespace {

constexpr int kAttemptsAtPlace = 3;

}  // namespace

PlaceEnd PlaceReadings::read(const std::string& id, const TipPose& tip) {
  const TrackerAnswer answer = readings_.take_tool(id, tip);
  switch (answer.status) {
    case TrackerStatus::kOk:
    case TrackerStatus::kElsewhere:
      break;
    case TrackerStatus::kSkipped:
      return PlaceEnd::kSkip;
    case TrackerStatus::kRepeat:
      return PlaceEnd::kRepeat;
    case TrackerStatus::kFailed:
      return end_of_bad(id, answer.fault);
  }
  return PlaceEnd::kKeep;
}

PlaceEnd PlaceReadings::end_of_bad(const std::string& id, const std::string& fault) {
  spdlog::warn(fmt::format("{}: {}", id, fault));
  attempts_ = id == bad_id_ ? attempts_ + 1 : 1;
  bad_id_ = id;
  if (on_bad_ == BadReading::kSkip) return PlaceEnd::kSkip;
  if (on_bad_ == BadReading::kRepeat && attempts_ < kAttemptsAtPlace) return PlaceEnd::kRepeat;
  throw no_reading_of(fmt::format("place '{}'", id), fault);
}

}  // namespace planar
