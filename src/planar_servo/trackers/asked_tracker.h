#pragma once

#include <memory>
#include <optional>
#include <string>

#include "planar_servo/core/operator.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/tables/tracker_table.h"

namespace planar {

/// As Tracker::keeps() does.
std::optional<bool> keeps_reading(Operator& person, const std::string& id);

/// A tracker that somebody works by hand, who reports its readings. Enter says
/// that a point was measured, and its reading stands in the tracker's own table; three numbers are
/// the reading itself; s skips the point, r repeats it.
class AskedTracker final : public Tracker {
 public:
  /// `dialect` says how the numbers are typed.
  AskedTracker(TrackerDialect dialect, std::shared_ptr<Operator> person);

  // Both throw WorkError when nobody can answer.
  TrackerAnswer measure_tool(const std::string& place) override;
  TrackerAnswer measure_monument(const std::string& id) override;
  std::optional<bool> keeps(const std::string& id) override { return keeps_reading(*person_, id); }
  void await_tool() override;
  void ask_of(const std::shared_ptr<Operator>& person) override { person_ = person; }
  int readings_per_monument() const override { return 1; }

 private:
  TrackerAnswer ask(const std::string& what);

  TrackerDialect dialect_;
  std::shared_ptr<Operator> person_;
};

}  // namespace planar
