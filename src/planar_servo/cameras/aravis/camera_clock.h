#pragma once

#include <optional>

namespace planar {

/// Dates a camera's frames by the camera's own clock. Delays of the camera, the link and this host
/// can only make a frame arrive later. The least difference between arrival and stamp is therefore
/// the clocks' offset plus the shortest delay, and it grows no faster than the clocks drift apart.
/// Where in the exposure the stamp is taken does not matter as long as it stays the same.
///
/// Frames are dated by their arrival when the camera's clock stands still or runs fast, and once
/// after it jumps. A slow clock makes frames seem later and later, as a growing queue in the camera
/// does; but a queue ends with its stream. When frames come too late, begin a new stream: if its
/// first frame then dates from before the stream's beginning, the clock is not believed any more.
class CameraClock {
 public:
  /// Notes that a stream begins at `start_s` on the steady clock; its frames are stamped later.
  void begin_stream(double start_s);

  /// Returns when a frame that the camera stamped `device_s` would have arrived without delay, on
  /// the steady clock; never later than its arrival at `arrival_s`. Frames must be given in the
  /// order of their arrival. Throws std::invalid_argument unless both times are finite.
  double due_s(double device_s, double arrival_s);

  /// Returns false once the clock was found to run slow; every frame is then due when it arrives.
  bool believed() const { return believed_; }

 private:
  std::optional<double> last_device_s_;
  std::optional<double> start_s_;  ///< beginning of a stream that has brought no frame yet
  double offset_s_{0.0};  ///< from the camera's clock to the steady one, with the shortest delay
  bool believed_{true};
};

}  // namespace planar
