#pragma once

#include <optional>

namespace planar {

/// Dates a camera's frames by the camera's own clock. Delays of the camera, the link and this host
/// only ever make a frame's arrival later. So the least difference between arrivals and stamps is
/// what the clocks differ by and the quickest frame's way; it can grow no faster than two clocks
/// drift apart. Where in an exposure the stamps lie does not matter, only that it stays.
///
/// A clock that stands still or runs fast, and the first frame after a jump, leave the arrival as
/// the date. A clock that runs slow makes frames seem later and later, as a growing queue does; but
/// a queue ends with its stream. Therefore begin a new stream when frames come too late to be of
/// use: if its first frame then dates from before its beginning, the clock is not believed any
/// more.
class CameraClock {
 public:
  /// A stream begins at `start_s` on the steady clock: whatever it brings is stamped later.
  void begin_stream(double start_s);

  /// When on the steady clock a frame, stamped `device_s` by the camera, would have arrived if
  /// nothing had held it up; never later than its arrival at `arrival_s`. Frames are to be given in
  /// the order of their arrival. Throws std::invalid_argument unless both times are finite.
  double due_s(double device_s, double arrival_s);

  /// False once the clock has been found to run slow: then every frame is due when it arrives.
  bool believed() const { return believed_; }

 private:
  std::optional<double> last_device_s_;
  std::optional<double> start_s_;  ///< of a stream that has brought no frame yet
  double offset_s_{0.0};  ///< from the camera's clock to the steady one, by the quickest way
  bool believed_{true};
};

}  // namespace planar
