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

  /// Returns false once the clock was found to run slow; frames are due when they arrive then.
  bool believed() const { return believed_; }

 private:
  std::optional<double> last_device_s_;
  std::optional<double> start_s_;  ///< beginning of a stream that has brought no frame yet
  double offset_s_{0.0};  ///< from the camera's clock to the steady one, with the shortest delay
  bool believed_{true};
};

/// Memory for the frames that a camera with these settings fills, allocated once.
class FrameMemory {
 public:
  using Block = std::unique_ptr<std::uint8_t, void (*)(void*)>;

  explicit FrameMemory(const AravisSettings& settings);
  const std::vector<Block>& blocks() const { return blocks_; }
  /// Returns the size of a block.
  std::size_t bytes() const { return bytes_; }

 private:
  std::vector<Block> blocks_;
  std::size_t bytes_{0};
};

/// One connection to a camera, from opening to loss. Its calls may block for seconds when the
/// camera is gone, so use it from a thread of its own. A failure ends it and throws WorkError.
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

  /// Ends any stream and starts one of the smallest region on the camera's raster that holds this.
  void start(const cv::Rect& region_px);

  // These act while the stream continues.
  /// Moves the region. Its size must be that given to start().
  void move(const cv::Rect& region_px);
  void expose(const CameraExposure& exposure);
  /// Switches the strobe of the settings on or off.
  void light(bool on);
  /// Starts one exposure by command.
  void trigger();
  /// Waits for a frame; empty when none comes in time.
  std::optional<Arrival> receive(double timeout_s);
  /// Reads one of features() back, each time the next.
  void require_unchanged();

  /// Returns whether the camera has not answered for some seconds or its cable is out.
  bool lost() const;
  /// Returns the number by which the camera is opened again, as AravisSettings::id has it.
  const std::string& id() const;
  /// Returns maker, model, firmware and serial number, as far as the camera tells them.
  std::string identity() const;
  /// Returns the settings on which pictures depend, as opening or expose() left them.
  const std::vector<std::pair<std::string, std::string>>& features() const;
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
