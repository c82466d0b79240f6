#pragma once

#include <string>

#include "planar_servo/core/names.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/judge/reflector_readings.h"

namespace planar {

/// Says what happens to a place that the tracker gives no reading of.
enum class BadReading {
  kRepeat,  ///< it is taken again, three times in all; then the recording stops
  kSkip,    ///< it is left out of the recording
  kStop,    ///< the recording stops
};

constexpr Named<BadReading> kBadReadings[] = {
    {BadReading::kRepeat, "repeat"}, {BadReading::kSkip, "skip"}, {BadReading::kStop, "stop"}};

/// Says what is to be done with a place once the tracker was asked.
enum class PlaceEnd { kKeep, kSkip, kRepeat };

/// Takes the readings of a recording's places, and decides what becomes of a place without one.
class PlaceReadings {
 public:
  /// The readings must outlive this.
  PlaceReadings(ReflectorReadings& readings, BadReading on_bad)
      : readings_(readings), on_bad_(on_bad) {}

  /// Reads the tool, which stands at `tip` for the place `id`. Throws WorkError when the recording
  /// is to stop.
  PlaceEnd read(const std::string& id, const TipPose& tip);

 private:
  PlaceEnd end_of_bad(const std::string& id, const std::string& fault);

  ReflectorReadings& readings_;
  BadReading on_bad_;
  std::string bad_id_;  ///< the place that is being repeated
  int attempts_{0};     ///< made there
};

}  // namespace planar
