#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/trackers/tracker_kinds.h"

namespace planar {

/// One line that came from a tracker's program: a reading, or why it is none.
struct StreamEvent {
  std::optional<StreamedReading> reading;
  std::string fault;  ///< empty when there is a reading
  double arrived_s{0.0};
};

/// Stands between a thread that receives text and a tracker that waits for readings. All functions
/// may be called from any thread.
class ReadingStream {
 public:
  /// `source` stands in messages, a file or an address.
  ReadingStream(std::string source, TrackerDialect dialect);

  // These are for the thread that receives.
  /// What follows begins anew: with a header, where the dialect has one.
  void begin_anew();
  /// Takes text as it came, whole lines or parts of them. A line counts once its end has come.
  void take(std::string_view text);
  /// Says why nothing comes at present.
  void lose(const std::string& why);

  // These are for the tracker.
  /// Discards everything that came so far.
  void forget();
  /// Waits for the next line that was meant as a reading. Empty when none comes in time.
  std::optional<StreamEvent> next(double patience_s);
  /// Says why nothing comes; empty when nothing is known to be wrong.
  std::string loss() const;
  bool has_columns() const;
  const std::string& source() const { return source_; }

 private:
  void take_line(std::string_view line);

  const std::string source_;
  const TrackerDialect dialect_;
  SteadyClock clock_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::optional<TrackerLines> lines_;  ///< a stream that begins anew is read by a new one
  std::string begun_line_;
  std::deque<StreamEvent> events_;
  std::string loss_;
};

/// Something that feeds a ReadingStream until it is destroyed.
class StreamFeed {
 public:
  StreamFeed() = default;
  StreamFeed(const StreamFeed&) = delete;
  StreamFeed& operator=(const StreamFeed&) = delete;
  virtual ~StreamFeed() = default;
};

/// Decides when a stream of readings has come to rest. The reflector rests when its readings over
/// half a second, at least five of them, scatter by no more than half as much again as the cell's
/// `tracker.sigma_mm` states (rms per axis); their mean is the reading.
class RestWindow {
 public:
  explicit RestWindow(const TrackerSettings& tracker) : tracker_(tracker) {}

  /// Takes the next reading, which arrived at this time on the computer's clock.
  void add(const StreamedReading& reading, double arrived_s);

  /// Returns the mean reading at rest, whose time is the tracker's or, where it tells none, that of
  /// arrival.
  std::optional<TrackerReading> at_rest() const;

  /// Returns true when all readings are the same to the last digit, although that digit is finer
  /// than the noise, or all are zero, as programs write them without a beam.
  bool is_frozen() const;

  bool is_empty() const { return window_.empty(); }

  /// Says by how much the readings scatter, and by how much they may.
  std::string scatter_text() const;

 private:
  struct Arrived {
    StreamedReading reading;
    double arrived_s;
  };

  bool is_full() const;
  Eigen::Vector3d mean() const;
  double scatter() const;
  double bound() const;

  TrackerSettings tracker_;
  std::deque<Arrived> window_;
};

/// Says how long a tracker's program is waited for, seconds.
struct StreamPatience {
  double silence_s{5.0};    ///< without any line
  double rest_s{60.0};      ///< until the readings come to rest
  double carried_s{300.0};  ///< while somebody carries the reflector to a monument or the tool
};

/// A tracker whose program writes readings all the time. A reading of it is the mean at rest
/// (RestWindow) of what arrives after it was asked for. Where the lines have names, a monument is
/// what is read under its name, and the tool what is read under any other; otherwise somebody at
/// hand says when the reflector is on a monument, and when it is back on the tool. What is read
/// where the last monument was is never the tool.
class StreamTracker final : public Tracker {
 public:
  /// `feed` feeds `stream` and may be null for a stream that somebody else feeds.
  StreamTracker(const CellSettings& cell, bool has_ids, std::shared_ptr<ReadingStream> stream,
                std::unique_ptr<StreamFeed> feed, std::shared_ptr<Operator> person,
                const StreamPatience& patience = {});

  TrackerAnswer measure_tool(const std::string& place) override;
  // Both throw WorkError when somebody is to be asked and nobody can answer.
  TrackerAnswer measure_monument(const std::string& id) override;
  std::optional<bool> keeps(const std::string& id) override { return keeps_reading(*person_, id); }
  void await_tool() override;
  void stop_when(const std::function<bool()>& stop) override { stop_ = stop; }
  void ask_of(const std::shared_ptr<Operator>& person) override { person_ = person; }
  int readings_per_monument() const override { return 1; }

 private:
  /// Says why a reading does not count; empty when it does.
  using WhyNot = std::function<std::string(const StreamedReading&)>;
  /// The beam breaks while somebody carries the reflector: the program may be silent then, write
  /// lines that are no readings, or repeat itself.
  enum class Beam { kHolds, kBreaks };
  TrackerAnswer measure(const WhyNot& why_not, Beam beam = Beam::kHolds);
  std::string why_not_of_tool(const StreamedReading& reading) const;
  /// Returns the answer, and notes where the reflector was left.
  TrackerAnswer of_monument(const std::string& id, const TrackerAnswer& answer);
  /// Returns the stream's next line, or nothing after `patience_s`.
  std::optional<StreamEvent> hear(double patience_s);
  /// `other` says why the last line that came does not count; empty where none came.
  TrackerAnswer silent(double waited_s, const std::string& other) const;

  TrackerSettings tracker_;
  std::set<std::string> monuments_;
  bool has_ids_;
  std::shared_ptr<ReadingStream> stream_;
  std::unique_ptr<StreamFeed> feed_;  ///< ends before the stream does
  std::shared_ptr<Operator> person_;
  StreamPatience patience_;
  std::function<bool()> stop_;
  std::optional<std::pair<std::string, Eigen::Vector3d>> left_at_;  ///< a monument
};

}  // namespace planar
