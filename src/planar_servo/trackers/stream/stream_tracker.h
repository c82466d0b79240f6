#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/trackers/ask/terminal.h"
#include "planar_servo/trackers/stream/reading_stream.h"

namespace planar {

/// Says how long a tracker's program is waited for, seconds.
struct StreamPatience {
  double silence_s{5.0};    ///< without any line
  double rest_s{60.0};      ///< until the readings come to rest
  double carried_s{300.0};  ///< while somebody carries the reflector to a monument or the tool
};

/// A tracker whose program writes readings all the time. A reading of it is the mean at rest
/// (RestWindow) of what arrives after it was asked for. Where the lines have names, a monument is
/// what is read under its name, and the tool what is read under any other; otherwise somebody at
/// the terminal says when the reflector is on a monument, and when it is back on the tool.
class StreamTracker final : public Tracker {
 public:
  /// `feed` feeds `stream` and may be null for a stream that somebody else feeds.
  StreamTracker(const CellSettings& cell, bool has_ids, std::shared_ptr<ReadingStream> stream,
                std::unique_ptr<StreamFeed> feed, Terminal terminal = Terminal(),
                const StreamPatience& patience = {});

  TrackerAnswer measure_tool(const std::string& place) override;
  // Both throw WorkError when somebody is to be asked and nobody can answer.
  TrackerAnswer measure_monument(const std::string& id) override;
  void await_tool() override;
  void stop_when(const std::function<bool()>& stop) override { stop_ = stop; }
  int readings_per_monument() const override { return 1; }

 private:
  using Wanted = std::function<bool(const StreamedReading&)>;
  TrackerAnswer measure(const Wanted& wanted);
  /// Waits, while the beam may break, for readings at rest.
  TrackerAnswer wait_for(const Wanted& wanted);
  bool is_of_tool(const StreamedReading& reading) const;
  /// Returns what the stream says next, or nothing after `patience_s`.
  std::optional<StreamEvent> hear(double patience_s);
  TrackerAnswer silent(double waited_s) const;

  TrackerSettings tracker_;
  std::set<std::string> monuments_;
  bool has_ids_;
  std::shared_ptr<ReadingStream> stream_;
  std::unique_ptr<StreamFeed> feed_;  ///< ends before the stream does
  Terminal terminal_;
  StreamPatience patience_;
  std::function<bool()> stop_;
};

}  // namespace planar
