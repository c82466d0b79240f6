#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>

#include "planar_servo/base/devices/frame_source.h"

namespace planar {

/// Passes frames from the thread that talks to a camera to the thread that moves the arm. It takes
/// the servo's requests, hands over the newest frame and watches the age of the last good one.
class FrameMailbox {
 public:
  /// The camera counts as at fault when no good frame came for `age_limit_s`.
  FrameMailbox(const cv::Rect& region_px, double age_limit_s);

  // The servo's thread calls these.
  void ask_region(const cv::Rect& region_px);
  /// Waits for a frame whose exposure begins after this call.
  FrameResult next(double timeout_s);
  /// Returns the frame that followed the one returned last if it was kept; otherwise waits for it.
  FrameResult following(double timeout_s);
  std::optional<std::string> fault() const;
  FrameCounts counts() const;

  // The grabbing thread calls these.
  /// Returns the region that was asked for last.
  cv::Rect region() const;
  /// Sleeps until a frame is asked for, the region asked for differs from `region_px`, `deadline_s`
  /// passes or wake() is called.
  void sleep_until(double deadline_s, const cv::Rect& region_px);
  void wake();
  /// Notes a good frame of the region asked for as `region_px`, whose exposure began at `began_s`.
  /// Returns whether the servo can use it; deliver() it then.
  bool note_good(double began_s, const cv::Rect& region_px);
  /// Hands `frame` to the servo. The grabbing thread must no longer share its memory.
  void deliver(const Frame& frame);
  /// Counts a frame that must not be measured.
  void note_bad(FrameStatus status);
  /// Allows the camera `duration_s` without a frame, such as when its stream starts.
  void excuse(double duration_s);
  void lose(const std::string& reason);
  void find();
  /// Returns the seconds since the last good frame or the end of the last excuse.
  double age_s() const;

 private:
  FrameResult wait(std::unique_lock<std::mutex>& lock, double timeout_s);
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
