#pragma once

#include <string>
#include <vector>

#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/error.h"
#include "planar_servo/devices/tracker.h"

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

}  // namespace planar
