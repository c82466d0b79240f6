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
/// camera is gone, so it belongs to a thread of its own. Every failure throws WorkError; a
/// connection that threw is of no further use.
class AravisLink {
 public:
  /// A frame as it came; its data stay until the next call of receive() or start().
  struct Arrival {
    bool complete{false};  ///< the rest is valid only then
    bool repeated{false};  ///< it equals the frame before it, byte for byte
    std::uint64_t id{0};
    double due_s{0.0};  ///< when its arrival should have begun, by CameraClock, on the steady clock
    double late_s{0.0};  ///< by how much later it began
    cv::Rect region_px;
    const std::uint8_t* data{nullptr};
  };

  /// Opens the camera and applies every setting; `memory` must outlive the link.
  AravisLink(const AravisSettings& settings, FrameMemory& memory);
  ~AravisLink();

  /// Starts to stream this region, stopping what streamed before. Returns the region that the
  /// camera can do: the smallest on its raster of increments that holds this one.
  cv::Rect start(const cv::Rect& region_px);

  /// Moves the region while the stream goes on; its size must be that of start(). Returns as above.
  cv::Rect move(const cv::Rect& region_px);

  /// Sets exposure time and gain while the stream goes on.
  void expose(const CameraExposure& exposure);

  /// Starts one exposure by command.
  void trigger();

  /// Waits for a frame; empty when none comes.
  std::optional<Arrival> receive(double timeout_s);

  /// The other side has not answered for some seconds, or the cable is out.
  bool lost() const;

  // Of the stream that start() began.
  std::size_t frame_bytes() const;
  /// Bytes of a GigE packet, its headers included; 0 on USB.
  int packet_size() const;
  /// Frames for which no memory was free.
  std::uint64_t underruns() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
