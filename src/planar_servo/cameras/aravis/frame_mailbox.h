#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>

#include "planar_servo/devices/frame_source.h"

namespace planar {

/// Stands between the thread that talks to a camera and the thread that steers the arm: takes the
/// servo's wishes, hands over the newest frame, and watches how old the last good frame is.
class FrameMailbox {
 public:
  /// The camera is at fault when no good frame came for `age_limit_s`.
  FrameMailbox(const cv::Rect& region_px, double age_limit_s);

  // The servo's side.
  void ask_region(const cv::Rect& region_px);
  /// Waits for a frame whose exposure begins from now on.
  FrameResult next(double timeout_s);
  /// The frame after the one handed over last, kept since it came; without one as next().
  FrameResult following(double timeout_s);
  std::optional<std::string> fault() const;
  FrameCounts counts() const;

  // The grabbing thread's side.
  /// The region that was asked for last.
  cv::Rect region() const;
  /// Sleeps until a frame or another region than `region_px` is asked for, until `deadline_s` or
  /// wake().
  void sleep_until(double deadline_s, const cv::Rect& region_px);
  void wake();
  /// A good frame whose exposure began at `began_s` in the region that was asked for as `region_px`
  /// has come. True when the servo waits for it, or will if it asks on: then deliver() it.
  bool note_good(double began_s, const cv::Rect& region_px);
  /// `frame` must not be shared with the grabbing thread any more.
  void deliver(const Frame& frame);
  /// A frame that must not be measured.
  void note_bad(FrameStatus status);
  /// The stream is being started: no frame is missed before `duration_s` are over.
  void excuse(double duration_s);
  void lose(const std::string& reason);
  void find();
  /// Seconds since the last good frame, excuses taken into account.
  double age_s() const;

 private:
  FrameResult wait(std::unique_lock<std::mutex>& lock, double deadline_s);
  double age_locked_s() const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  double age_limit_s_;
  cv::Rect region_px_;
  std::optional<double> wanted_since_s_;
  bool waiting_{false};
  std::optional<Frame> frame_;
  FrameStatus last_trouble_{FrameStatus::kTimeout};  ///< since the servo began to wait
  FrameStatus last_status_{FrameStatus::kOk};
  double good_until_s_;  ///< the last good frame's arrival, or the end of an excuse
  bool lost_{false};
  bool woken_{false};
  std::string reason_;
  FrameCounts counts_;
};

}  // namespace planar
