#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// Takes whole frames of a scene at rest, exposed as long as given or else as the camera does. It
/// is left exposed as it was. Throws WorkError for a frame that does not come.
std::vector<Frame> whole_frames(FrameSource& camera, int count,
                                const std::optional<double>& exposure_s);

/// Pictures of works, and one of the reference lamps where the marks have an exposure of their own.
struct WorkFrames {
  std::vector<Frame> of_marks;
  std::optional<Frame> of_lamps{};
};

/// Takes whole frames of works, exposed as long as given or else as the camera does. Throws as
/// whole_frames() does.
WorkFrames frames_of_work(FrameSource& camera, int count, const std::optional<double>& exposure_s);

/// Writes a picture in the form that the name's extension says. `how` is as for cv::imencode().
void write_picture(const std::filesystem::path& file, const cv::Mat& image,
                   const std::vector<int>& how = {});

/// Looks every minute whether workpieces still lie where they were found.
class WorkWatch {
 public:
  /// Takes the works, null for none, and vision, camera and clock, which must outlive it.
  WorkWatch(std::shared_ptr<const LaidWorks> works, const VisionCalibration& vision,
            FrameSource& camera, const Clock& clock)
      : works_(std::move(works)), vision_(vision), camera_(camera), clock_(clock) {}

  bool is_due() const;
  /// Takes the arm elsewhere and returns whether it is there.
  using StandAside = std::function<bool()>;
  /// Looks at all works while the arm rests. Returns what is wrong, or an empty text. Where no mark
  /// of a work is seen, it looks again from aside: the arm may hide a small work. Logs which marks
  /// are hidden. Throws as whole_frames() does.
  std::string examine(const StandAside& stand_aside);

 private:
  std::string look();

  std::shared_ptr<const LaidWorks> works_;
  const VisionCalibration& vision_;
  FrameSource& camera_;
  const Clock& clock_;
  std::optional<double> looked_s_;
  std::string hidden_;     ///< the marks that were named last
  bool hides_all_{false};  ///< of a work
};

}  // namespace planar
