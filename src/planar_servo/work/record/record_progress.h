#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/report/live_view.h"
#include "planar_servo/work/record/recorder.h"
#include "planar_servo/work/record/recording_start.h"

namespace planar {

/// Says how far a recording has come and how long it will take: in the terminal's status line, in
/// the log once a minute where there is none, and on a map. Where somebody measures each place by
/// hand, every place has a line of its own, because questions stand between them.
class RecordProgress {
 public:
  /// `joints` are those of the request's plan, and `begun` is what its recording holds. `display`
  /// may be null. Request, clock and display must outlive this. The pace is that of `clock`.
  RecordProgress(const RecordRequest& request, const std::vector<Joints>& joints,
                 const BegunRecording& begun, const Clock& clock, LivePicture* display);

  /// Says that this row of the plan is recorded from now on.
  void begin(std::size_t row);
  /// Says what has become of it.
  void end(std::size_t row, PlaceMark mark);
  /// Shows the map of all that was recorded, and no line.
  void finish();

  /// Returns how many rows are done or left out, of how many, and what is left:
  /// "14 of 135, about 9 min and 15 views of the board left".
  std::string text() const;

 private:
  /// Rows that take about as long as each other.
  enum class Sort { kRead, kWatched, kBoard };
  struct Pace {
    std::size_t all{0}, over{0}, timed{0};
    double seconds{0.0};
  };

  static Sort sort_of(const PlanRow& row);
  const Pace& pace(Sort sort) const { return paces_[static_cast<std::size_t>(sort)]; }
  Pace& pace(Sort sort) { return paces_[static_cast<std::size_t>(sort)]; }
  std::string left_text() const;
  void tell(const PlanRow& row);
  void say(const std::string& message);
  RecordingState state() const;
  void show(const RecordingState& state) const;
  LiveView view_of(const RecordingState& state) const;

  const RecordRequest& request_;
  const Clock& clock_;
  LivePicture* display_;
  StatusLine line_;
  std::vector<Eigen::Vector2d> places_B_;  ///< of all rows; of no meaning for views of the board
  std::vector<PlaceMark> marks_;
  std::array<Pace, 3> paces_;
  double begun_s_{0.0};  ///< the row
  std::optional<double> told_s_;
};

}  // namespace planar
