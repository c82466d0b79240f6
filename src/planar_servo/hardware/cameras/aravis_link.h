#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"

namespace planar {

/// Dates a camera's frames by the camera's own clock. Delays in the camera, the link and this host
/// can only make a frame arrive later. The least difference between arrival and stamp is therefore
/// the clocks' offset plus the shortest delay, and it grows no faster than the clocks drift apart.
/// It does not matter when during the exposure the stamp is taken, as long as that stays the same.
///
/// Frames are dated by their arrival when the camera's clock stands still or runs fast, and once
/// after it jumps. A slow clock makes frames seem later and later, as does a growing queue in the
/// camera; but a queue ends with its stream. When frames come too late, begin a new stream: if its
/// first frame is then dated before the stream's beginning, the clock is no longer trusted.
class CameraClock {
 public:
  /// Notes that a stream begins at `start_s` on the steady clock; its frames are stamped later.
  void begin_stream(double start_s);

  /// Returns when a frame stamped `device_s` by the camera would have arrived without delay, on the
  /// steady clock; never later than its arrival at `arrival_s`. Frames must be given in the order
  /// of their arrival. Throws std::invalid_argument unless both times are finite.
  double due_s(double device_s, double arrival_s);

  /// Returns false once the clock was found to run slow; from then on every frame is due when it
  /// arrives.
  bool believed() const { return believed_; }

 private:
  std::optional<double> last_device_s_;
  std::optional<double> start_s_;  ///< beginning of a stream that has brought no frame yet
  double offset_s_{0.0};  ///< from the camera's clock to the steady one, with the shortest delay
  bool believed_{true};
};

/// Memory for the frames that a camera fills, allocated once for its largest frame.
class FrameMemory {
 public:
  FrameMemory(int blocks, std::size_t bytes);
  int blocks() const { return static_cast<int>(blocks_.size()); }
  std::size_t bytes() const { return bytes_; }
  std::uint8_t* block(int i) { return blocks_.at(static_cast<std::size_t>(i)).get(); }

 private:
  struct Free {
    void operator()(std::uint8_t* block) const;
  };
  std::vector<std::unique_ptr<std::uint8_t, Free>> blocks_;
  std::size_t bytes_;
};

/// One connection to a camera, from opening to loss. Its calls may block for seconds when the
/// camera is gone, so use it from a thread of its own. Every failure throws WorkError; after that
/// the connection cannot be used.
class AravisLink {
 public:
  /// A frame as it came. Its data stay valid until the next receive() or start().
  struct Arrival {
    bool complete{false};  ///< if false, nothing else here is valid
    bool repeated{false};  ///< whether it equals the frame before it, byte for byte
    std::uint64_t id{0};
    double due_s{0.0};   ///< when its arrival was due by CameraClock, on the steady clock
    double late_s{0.0};  ///< how much later it arrived
    cv::Rect region_px;
    const std::uint8_t* data{nullptr};
  };

  /// Opens the camera and applies all settings. `memory` must outlive the link.
  AravisLink(const AravisSettings& settings, FrameMemory& memory);
  ~AravisLink();

  /// Starts to stream this region and ends any stream before. Returns the region that the camera
  /// takes: the smallest on its raster that contains the wanted one.
  cv::Rect start(const cv::Rect& region_px);

  /// Moves the region while the stream continues, and returns it as start() does. Its size must be
  /// that given to start().
  cv::Rect move(const cv::Rect& region_px);

  /// Sets exposure time and gain while the stream continues.
  void expose(const CameraExposure& exposure);

  /// Switches the strobe of the settings on or off while the stream continues.
  void light(bool on);

  /// Starts one exposure by command.
  void trigger();

  /// Waits for a frame; empty when none comes in time.
  std::optional<Arrival> receive(double timeout_s);

  /// Returns whether the camera has not answered for some seconds or its cable is out.
  bool lost() const;

  /// Returns maker, model, firmware and serial number, as far as the camera tells them.
  std::string identity() const;

  /// Returns the settings on which pictures depend, as opening or expose() left them.
  const std::vector<std::pair<std::string, std::string>>& features() const;

  /// Reads one of features() back, each time the next.
  void require_unchanged();

  /// Returns what opening has undone of what the camera did to its pictures; see make_plain().
  const std::vector<std::string>& made_plain() const;

  // These describe the stream that start() began.
  std::size_t frame_bytes() const;
  /// Returns the bytes of a GigE packet with its headers; 0 on USB.
  int packet_size() const;
  /// Returns how many frames were lost because no memory was free.
  std::uint64_t underruns() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
