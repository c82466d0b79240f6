#pragma once

#include <string>

#include "planar_servo/devices/tracker.h"
#include "planar_servo/files/tables/tracker_lines.h"
#include "planar_servo/trackers/ask/terminal.h"

namespace planar {

/// A tracker that somebody works by hand and of which this computer hears by the terminal. Enter
/// says that a point was measured, and its reading stands in the tracker's own table; three numbers
/// are the reading itself; s skips the point, r repeats it.
class AskedTracker final : public Tracker {
 public:
  /// `dialect` says how the numbers are typed.
  explicit AskedTracker(TrackerDialect dialect, Terminal terminal = Terminal());

  // Both throw WorkError when nobody can answer.
  TrackerAnswer measure_tool(const std::string& place) override;
  TrackerAnswer measure_monument(const std::string& id) override;
  void await_tool() override;
  int readings_per_monument() const override { return 1; }

 private:
  TrackerAnswer ask(const std::string& what);

  TrackerDialect dialect_;
  Terminal terminal_;
};

}  // namespace planar
