#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/work/record/recorder.h"
#include "planar_servo/work/record/recording_start.h"

namespace planar {

/// Says what is to be done with a place once the tracker was asked.
enum class PlaceEnd { kKeep, kSkip, kRepeat };

/// Takes the readings of a recording: of the monuments, of the places, and of the monuments once
/// more.
class RecordingReadings {
 public:
  /// What is read goes to `table`, a tracker.csv. All must outlive this.
  RecordingReadings(const RecordRequest& request, const BegunRecording& begun, Tracker& tracker,
                    GrowingFile& table);

  /// Returns whether readings are asked for from this row of the plan on that the recording does
  /// not hold.
  bool are_left(std::size_t row) const;

  /// Reads the monuments unless the recording holds them or no place is to be read, and waits until
  /// the reflector is back on the tool. Throws as ReflectorReadings and Tracker::await_tool() do.
  void read_first_monuments();

  /// Reads the tool, which stands at `tip` for the place `id`, and decides what becomes of a place
  /// without a reading. Throws WorkError when the recording is to stop.
  PlaceEnd read_place(const std::string& id, const TipPose& tip);

  /// Reads the monuments once more, or those that an earlier run has left of them. Does nothing the
  /// second time. Throws as ReflectorReadings does.
  void read_last_monuments();

  /// Returns these, if this run has read all of them.
  const std::vector<MonumentSeen>& last_monuments() const { return last_; }

 private:
  PlaceEnd end_of_bad(const std::string& id, const std::string& fault);

  const RecordRequest& request_;
  const BegunRecording& begun_;
  Tracker& tracker_;
  ReflectorReadings reflector_;
  bool reads_;  ///< this run reads places
  std::vector<MonumentSeen> first_, last_;
  bool is_done_{false};
  std::string bad_id_;  ///< the place that is being repeated
  int attempts_{0};     ///< made there
};

}  // namespace planar
