#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

struct MonumentSeen {
  std::string id;
  TrackerReading reading;
};

/// Returns the readings with the deviations that the cell states.
std::vector<MonumentReading> monument_readings(const CellSettings& cell,
                                               const std::vector<MonumentSeen>& seen);

/// A round over a cell's monuments, compared while it is made: with the round before, which shows
/// whether tracker or monuments moved, or, where there is none, with the cell file.
class MonumentRound {
 public:
  /// Continues a round that has `seen` some already. `before` is empty for the first round. The
  /// cell must outlive this.
  MonumentRound(const CellSettings& cell, const std::vector<MonumentSeen>& before,
                std::vector<MonumentSeen> seen);

  const std::vector<MonumentSeen>& seen() const { return seen_; }
  void add(const std::vector<MonumentSeen>& readings);

  /// Describes the readings of one monument that follow: how many, where they are in the tracker's
  /// frame, how they scatter, and how they differ from the round before or the cell file.
  std::string words(const std::vector<MonumentSeen>& readings) const;

  /// Says in which way readings of one monument contradict those that agreed so far: by more than a
  /// single reading is stated to deviate, see check_monuments() and check_drift(). Empty when they
  /// do not, and when the round was in contradiction before.
  Refusal contradiction(const std::vector<MonumentSeen>& readings) const;

  /// Says what noise does not explain about the round; empty when it explains all.
  Refusal doubt() const { return verdict(seen_).doubt; }

 private:
  std::vector<MonumentSight> sights(const std::vector<MonumentSeen>& seen) const;
  MonumentVerdict verdict(const std::vector<MonumentSeen>& seen) const;
  /// Returns the position that a monument's distances are compared by; null when it has none.
  const MonumentSight* reference(const std::string& id) const;
  std::string distance_words(const MonumentSight& monument) const;

  const CellSettings& cell_;
  std::vector<MonumentSeen> seen_;
  std::vector<MonumentSight> before_;
};

class GrowingFile;

/// The fewest monuments that tie a tracker to the base.
constexpr std::size_t kLeastMonuments = 3;

/// Returns the error that ends a program whose tracker gives no reading of `what`, such as
/// "monument 'datum1'".
WorkError no_reading_of(const std::string& what, const std::string& fault);

/// Takes readings of the reflector: asks the tracker, checks its answer, and writes tracker.csv.
class ReflectorReadings {
 public:
  /// `table` is a tracker.csv. `stop` is asked between two attempts at a monument and while the
  /// tracker waits; it may be empty.
  ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                    std::function<bool()> stop);

  /// Reads every monument of the cell, but for what this round has `seen` already, and returns the
  /// whole round. Reports each reading at once and compares it with the round `before`, or else
  /// with the cell file; one that contradicts is taken again unless the person at the tracker keeps
  /// it, or nobody can be asked. Throws WorkError when one cannot be read in three attempts, when
  /// fewer than three are left because somebody skipped the others, and when asked to stop.
  std::vector<MonumentSeen> read_monuments(std::vector<MonumentSeen> seen = {},
                                           std::vector<MonumentSeen> before = {});

  /// Reads the tool, which stands at `tip` for the place `id`, once. A reading that has not moved
  /// although the tool has is a failed one.
  TrackerAnswer take_tool(const std::string& id, const TipPose& tip);

 private:
  /// Returns whether the monument was read; false when somebody skipped it.
  bool read_monument(const std::string& id, MonumentRound& round);
  /// Returns so many readings of a monument, none that stand in a table of the tracker's own; empty
  /// when somebody skipped it.
  std::optional<std::vector<MonumentSeen>> take_monument(const std::string& id, int count);
  bool is_kept(const std::string& id, const Refusal& contradiction);
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
