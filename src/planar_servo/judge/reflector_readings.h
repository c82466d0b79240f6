#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/devices/tracker.h"

namespace planar {

class GrowingFile;

/// The fewest monuments that tie a tracker to the base.
constexpr std::size_t kLeastMonuments = 3;

struct MonumentSeen {
  std::string id;
  TrackerReading reading;
};

/// Returns the error that ends a program whose tracker gives no reading of `what`, such as
/// "monument 'datum1'".
WorkError no_reading_of(const std::string& what, const std::string& fault);

/// Takes readings of the reflector: asks the tracker, doubts its answer, and writes tracker.csv.
class ReflectorReadings {
 public:
  /// `table` is a tracker.csv. `stop` is asked between two attempts at a monument and while the
  /// tracker waits; it may be empty.
  ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                    std::function<bool()> stop);

  /// Reads every monument of the cell, but for what this round has `seen` already, and returns the
  /// whole round. Throws WorkError when one cannot be read in three attempts, when fewer than three
  /// are left because somebody skipped the others, and when asked to stop.
  std::vector<MonumentSeen> read_monuments(std::vector<MonumentSeen> seen = {});

  /// Reads the tool, which stands at `tip` for the place `id`, once. A reading that has not moved
  /// although the tool has is a failed one.
  TrackerAnswer take_tool(const std::string& id, const TipPose& tip);

 private:
  bool read_monument(const std::string& id, std::vector<MonumentSeen>& seen);
  std::string fault_of(const TrackerReading& reading, const TipPose& tip) const;

  struct Taken {
    std::string id;
    TrackerReading reading;
    TipPose tip;
  };

  const CellSettings& cell_;
  Tracker& tracker_;
  GrowingFile& table_;
  std::function<bool()> stop_;
  std::optional<Taken> last_;  ///< reading of the tool
};

}  // namespace planar
