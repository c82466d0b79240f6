#include "planar_servo/work/record/recording_readings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {

RecordingReadings::RecordingReadings(const RecordRequest& request, const BegunRecording& begun,
                                     Tracker& tracker, GrowingFile& table)
    : request_(request),
      begun_(begun),
      tracker_(tracker),
      reflector_(request.cell, tracker, table, request.stop),
      reads_(are_left(0)),
      first_(begun.first_monuments) {}

bool RecordingReadings::are_left(std::size_t row) const {
  const std::vector<PlanRow>& plan = request_.plan;
  return std::any_of(plan.begin() + static_cast<std::ptrdiff_t>(row), plan.end(),
                     [&](const PlanRow& r) { return needs_reading(r.plan) && !begun_.has(r); });
}

void RecordingReadings::read_first_monuments() {
  if (!reads_) return;
  if (!begun_.dropped.empty()) {
    std::string table = tracker_header();
    for (const TrackerRow& reading : begun_.readings) table += tracker_line(reading);
    write_file(request_.recording / "tracker.csv", table);
    spdlog::warn("{}: a reading without frames, as a kill leaves it, is dropped and repeated",
                 fmt::join(begun_.dropped, ", "));
  }
  if (begun_.has_monuments) {
    spdlog::info(
        "the monuments are read already: nothing may have moved since, not the tracker either; "
        "otherwise name another folder");
  } else {
    // The tracker may have been moved since a round that no place has followed.
    if (!begun_.last_monuments) write_file(request_.recording / "tracker.csv", tracker_header());
    first_ = reflector_.read_monuments();
  }
  // Who reads the monuments, now or at the end of an earlier run, leaves the reflector there.
  if (!begun_.has_monuments || !begun_.last_monuments || !begun_.last_monuments->empty())
    tracker_.await_tool();
}

PlaceEnd RecordingReadings::read_place(const std::string& id, const TipPose& tip) {
  const TrackerAnswer answer = reflector_.take_tool(id, tip);
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

PlaceEnd RecordingReadings::end_of_bad(const std::string& id, const std::string& fault) {
  constexpr int kAttemptsAtPlace = 3;
  spdlog::warn(id + ": " + fault);
  attempts_ = id == bad_id_ ? attempts_ + 1 : 1;
  bad_id_ = id;
  if (request_.on_bad_reading == BadReading::kSkip) return PlaceEnd::kSkip;
  if (request_.on_bad_reading == BadReading::kRepeat && attempts_ < kAttemptsAtPlace)
    return PlaceEnd::kRepeat;
  throw no_reading_of(fmt::format("place '{}'", id), fault);
}

void RecordingReadings::read_last_monuments() {
  if (std::exchange(is_done_, true)) return;
  if (reads_) {
    spdlog::info("the monuments are read once more, which shows whether anything has moved");
    last_ = reflector_.read_monuments({}, first_);
    spdlog::info("the readings are complete: the tracker is not needed for this plan any more");
  } else if (begun_.last_monuments) {
    reflector_.read_monuments(*begun_.last_monuments, first_);
  }
}

}  // namespace planar
