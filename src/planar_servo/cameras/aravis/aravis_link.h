#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/cameras/aravis/pixel_format.h"
#include "planar_servo/devices/frame_source.h"

namespace planar {

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
/// the connection is of no further use.
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

  /// Starts to stream this region and ends the stream before. Returns the region that the camera
  /// takes: the smallest on its raster that holds the wanted one.
  cv::Rect start(const cv::Rect& region_px);

  /// Moves the region while the stream goes on and returns it like start(). Its size must be that
  /// given to start().
  cv::Rect move(const cv::Rect& region_px);

  /// Sets exposure time and gain while the stream goes on.
  void expose(const CameraExposure& exposure);

  /// Starts one exposure by command.
  void trigger();

  /// Waits for a frame; empty when none comes in time.
  std::optional<Arrival> receive(double timeout_s);

  /// Returns whether the camera has not answered for some seconds or its cable is out.
  bool lost() const;

  // // These describe the stream that start() began.
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
