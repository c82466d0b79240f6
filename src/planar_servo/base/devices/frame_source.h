#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace planar {

/// Puts the calibration board into the camera's view. A virtual cell does so by itself; a person is
/// guided instead.
class BoardPresenter {
 public:
  virtual ~BoardPresenter() = default;

  /// Holds the board tilted into the view. `view` counts from 0, and each number gives another
  /// pose.
  virtual void hold_board(int view) = 0;
  /// Lays the board on the plane of motion: view 0 in the middle of the camera's view and about
  /// square to it, each other anywhere that the camera sees the whole board, at any turn.
  virtual void lay_board(int view) = 0;
  virtual void remove_board() = 0;
};

/// One image of the camera. The centre of the sensor's top-left pixel is (0, 0), and pixel (c, r)
/// of `image` is sensor pixel (region_px.x + c, region_px.y + r).
struct Frame {
  cv::Mat image;        ///< CV_8UC1, of the region's size
  cv::Rect region_px;   ///< where the image lies on the sensor
  double t_s{0.0};      ///< when the exposure began, on the source's clock
  std::uint64_t id{0};  ///< the camera's own frame number
};

enum class FrameStatus {
  kOk,
  kTimeout,     ///< no frame came in time
  kIncomplete,  ///< frames came in time, but parts of them were missing
  kFrozen,      ///< frames came, but all of them repeated one picture
  kLost,        ///< the camera is gone and being looked for
};

/// Returns the status as it stands in logs: "ok", "no_frame", "incomplete_frame", "frozen_frame",
/// "camera_lost".
const char* name(FrameStatus status);

struct FrameResult {
  FrameStatus status{FrameStatus::kTimeout};
  Frame frame;  ///< valid only when status is kOk
};

/// Counts all frames since the camera was opened, also those that nobody asked for.
struct FrameCounts {
  std::uint64_t complete{0};
  std::uint64_t incomplete{0};  ///< with parts missing; never handed over
  std::uint64_t frozen{0};      ///< repeating an earlier picture; never handed over
  std::uint64_t reopened{0};    ///< how often the camera came back after it was lost
};

/// Returns what was counted since `before`.
FrameCounts operator-(const FrameCounts& now, const FrameCounts& before);

/// Writes the counts as a sentence: "412 whole frames; left out: 3 with parts missing, 2 repeated;
/// the camera was lost and found 1 time".
std::string describe(const FrameCounts& counts);

struct CameraExposure {
  double time_s{0.0};
  double gain_db{0.0};
};

/// A camera. It hands out the next frame with its time, or says why there is none.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual cv::Size sensor_size_px() const = 0;

  /// Restricts the following frames to a region of the sensor. Throws std::invalid_argument when
  /// the region is empty or leaves the sensor.
  virtual void set_region(const cv::Rect& region_px) = 0;

  /// Waits for a whole frame of the region whose exposure begins after this call.
  virtual FrameResult next_frame() = 0;

  /// Returns the frame that followed the one returned last, which may have been exposed before this
  /// call. Use it for a scene that has stood still since. After set_region() it acts as
  /// next_frame().
  virtual FrameResult following_frame() { return next_frame(); }

  /// Says in words what is wrong with the camera now; empty while its frames come as they should.
  /// Answers at once, because it is asked every few milliseconds while the arm moves.
  virtual std::optional<std::string> fault() const = 0;

  virtual FrameCounts counts() const = 0;

  /// Returns the settings of the camera on which pictures depend, by its own names; empty where it
  /// has none.
  virtual std::vector<std::pair<std::string, std::string>> features() const { return {}; }

  virtual CameraExposure exposure() const = 0;

  /// Sets the exposure of all frames asked for from now on; this may take a while. Throws
  /// InputError unless the time is finite and positive and the gain finite, and WorkError when the
  /// camera refuses; the exposure is unchanged then.
  virtual void set_exposure(const CameraExposure& exposure) = 0;
};

/// Throws InputError unless the time is finite and positive and the gain finite.
void require_exposure(const CameraExposure& exposure);

/// Throws std::invalid_argument unless the region lies on the sensor and is not empty.
void require_region(const cv::Rect& region_px, const cv::Size& sensor_px);

}  // namespace planar
