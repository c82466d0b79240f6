#pragma once

#include <unistd.h>

#include <optional>
#include <string>

#include "planar_servo/devices/tracker.h"
#include "planar_servo/tables/tracker_table.h"

namespace planar {

/// Somebody who answers questions. By default it is who sits at the terminal of this program.
class Terminal {
 public:
  /// Asks on `out` and hears on `in`, both descriptors of open files, which stay open.
  explicit Terminal(int in = STDIN_FILENO, int out = STDERR_FILENO) : in_(in), out_(out) {}

  /// Returns the answered line without its end and without blanks around it. What was typed at a
  /// terminal before the question stood there is discarded; what a script sends is not. Throws
  /// WorkError when nobody can answer: standard input is closed or at its end, or the program was
  /// interrupted.
  std::string ask(const std::string& question) const;

  /// As Tracker::keeps() does.
  std::optional<bool> keeps(const std::string& id) const;

  /// Returns whether somebody sits at a terminal, and not a script.
  bool is_attended() const { return isatty(in_) != 0; }

 private:
  int in_;
  int out_;
};

/// A tracker that somebody works by hand, with its readings reported at the terminal. Enter says
/// that a point was measured, and its reading stands in the tracker's own table; three numbers are
/// the reading itself; s skips the point, r repeats it.
class AskedTracker final : public Tracker {
 public:
  /// `dialect` says how the numbers are typed.
  explicit AskedTracker(TrackerDialect dialect, Terminal terminal = Terminal());

  // Both throw WorkError when nobody can answer.
  TrackerAnswer measure_tool(const std::string& place) override;
  TrackerAnswer measure_monument(const std::string& id) override;
  std::optional<bool> keeps(const std::string& id) override { return terminal_.keeps(id); }
  void await_tool() override;
  int readings_per_monument() const override { return 1; }

 private:
  TrackerAnswer ask(const std::string& what);

  TrackerDialect dialect_;
  Terminal terminal_;
};

}  // namespace planar
