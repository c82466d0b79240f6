#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/names.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/devices/tracker.h"

namespace planar {

class GrowingFile;

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

/// A reading of a monument.
struct MonumentSeen {
  std::string id;
  TrackerReading reading;
};

/// Takes a recording's tracker readings: asks the tracker, judges its answer, and writes
/// tracker.csv.
class ReflectorReadings {
 public:
  /// `table` is the recording's tracker.csv. `stop` is asked between two attempts
  /// and while the tracker waits; it may be empty.
  ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                    BadReading on_bad, std::function<bool()> stop);

  /// Reads every monument of the cell, but for what this round has `seen` already, and returns the
  /// whole round. Throws WorkError when one cannot be read in three attempts, when fewer than three
  /// are left because somebody skipped the others, and when asked to stop.
  std::vector<MonumentSeen> read_monuments(std::vector<MonumentSeen> seen = {});

  /// Reads the tool, which stands at `tip` for the place `id`, once. A reading that has not moved
  /// although the tool has is a failed one.
  TrackerAnswer take_tool(const std::string& id, const TipPose& tip);

  /// Does as take_tool(), and decides what becomes of the place. Throws WorkError when the
  /// recording is to stop.
  PlaceEnd read_tool(const std::string& id, const TipPose& tip);

 private:
  bool read_monument(const std::string& id, std::vector<MonumentSeen>& seen);
  PlaceEnd end_of_bad(const std::string& id, const std::string& fault);
  std::string fault_of(const TrackerReading& reading, const TipPose& tip) const;

  struct Taken {
    std::string id;
    TrackerReading reading;
    TipPose tip;
  };

  const CellSettings& cell_;
  Tracker& tracker_;
  GrowingFile& table_;
  BadReading on_bad_;
  std::function<bool()> stop_;
  std::optional<Taken> last_;  ///< reading of the tool
  std::string bad_id_;         ///< the place that is being repeated
  int attempts_{0};            ///< made there
};

}  // namespace planar
