#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {

/// Is told, on the thread that uses the devices, what they say whenever they are asked.
struct DeviceWatch {
  std::function<void(const Frame&)> frame;
  std::function<void(const std::optional<std::string>&)> camera_fault;
  std::function<void(const std::array<DriveStatus, 3>&)> drives;
};

/// Returns the devices of a cell such that `watch` sees what passes. The clock of a virtual cell
/// runs in real time then: who waits by it waits.
std::unique_ptr<CellDevices> watched(std::unique_ptr<CellDevices> devices, bool is_virtual,
                                     DeviceWatch watch);

/// Holds what the camera has shown last, and encodes it once for all, when the first reader asks.
class Pictures {
 public:
  /// A JPEG, and the number of the picture it shows.
  struct Jpeg {
    std::shared_ptr<const std::string> bytes;  ///< null before the first picture
    std::uint64_t number{0};
  };

  explicit Pictures(const cv::Size& sensor_px) : sensor_px_(sensor_px) {}

  const cv::Size& sensor_px() const { return sensor_px_; }

  /// Takes a frame of the sensor or a region, whose pixels nobody changes, and returns its number.
  std::uint64_t take(const Frame& frame);
  /// Says where the lamps are, in pixels of the sensor.
  void aim(const std::array<Eigen::Vector2d, 2>& lamps_px);

  /// Returns the whole picture, at most kMostWidth_px wide. A region taken since the last whole
  /// frame stands in it at full brightness; what is older is darker.
  Jpeg whole();
  /// Returns the surroundings of lamp 0 or 1, pixel by pixel; nothing before the lamps were seen.
  Jpeg lamp(std::size_t index);

  static constexpr int kMostWidth_px = 1280;
  static constexpr int kLampSide_px = 160;

 private:
  /// A picture that was encoded already.
  struct Encoded {
    std::mutex mutex;  ///< the first reader encodes, the others wait for it
    Jpeg jpeg;
  };
  struct Shown {
    std::optional<Frame> whole, region;
    std::array<Eigen::Vector2d, 2> lamps_px;
    bool aimed{false};
    std::uint64_t number{0};
  };
  Shown shown() const;
  cv::Mat composed(const Shown& shown) const;

  cv::Size sensor_px_;
  mutable std::mutex mutex_;
  Shown shown_;
  Encoded whole_;
  std::array<Encoded, 2> lamps_;
};

/// Keeps the pictures of a cell's camera and notes what they show: lamps, sharpness and fixed
/// lamps. The thread that has the camera calls all but pictures().
class PictureWatch {
 public:
  PictureWatch(const CellSettings& cell, const std::optional<VisionCalibration>& vision,
               StateBoard& board);

  /// Takes any frame of the camera. Where somebody looks, it is examined a few times a second.
  void take(const Frame& frame, bool is_watched);
  /// Begins anew with the sharpest edges.
  void forget_best() { best_px_.reset(); }

  Pictures& pictures() { return pictures_; }

 private:
  void examine(const Frame& frame);
  std::vector<FixedLampState> fixed_lamps(const Frame& frame);

  StateBoard& board_;
  Pictures pictures_;
  SteadyClock clock_;
  CenterMethod method_;
  std::vector<ReferenceLamp> fixed_;
  LampDetector detector_;
  std::optional<LampPixels> lamps_px_;  ///< where they were last
  std::optional<double> best_px_;
  double examined_s_{0.0};  ///< when, by the steady clock
};

}  // namespace planar
