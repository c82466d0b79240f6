#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/files/tables/tracker_table.h"

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

}  // namespace planar
