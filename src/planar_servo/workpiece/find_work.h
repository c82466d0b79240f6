#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/workpiece/constellation.h"
#include "planar_servo/workpiece/fiducials.h"
#include "planar_servo/workpiece/work_pose.h"

namespace planar {

/// How a workpiece is looked for, and what is asked of it.
struct WorkSettings {
  WorkMap allowed{WorkMap::kRigid};  ///< the most general map that the drawing may have undergone
  /// Standard deviation per axis of a mark about its drawing, as an etched board or a milled plate
  /// has it, metres.
  double drawing_sigma{20e-6};
  std::optional<WorkPlace> place{};  ///< none: anywhere in the picture
  bool all{false};                   ///< of several works of the same drawing
};

/// A mark of a workpiece that was found.
struct FoundFiducial {
  Fiducial fiducial;
  Eigen::Vector2d uv_px{0.0, 0.0};  ///< of its image's centre, as seen at calibration
  Eigen::Vector2d p_B{0.0, 0.0};
  Eigen::Vector2d residual{0.0, 0.0};  ///< seen minus fitted, base frame
  double sigma{0.0};                   ///< of p_B per axis, metres
  double diameter{0.0};                ///< of a round one, metres; else 0
};

/// A workpiece that was found.
struct FoundWork {
  std::string id;  ///< empty for the only one
  WorkPose pose;
  std::vector<FoundFiducial> fiducials;
  double chance{1.0};                ///< of residuals as large as these
  std::vector<std::string> remarks;  ///< what a person should know
};

/// Workpieces of one drawing, as their file has them.
struct LaidWorks {
  std::filesystem::path file;
  std::optional<double> exposure_s;  ///< with which their marks are seen
  std::vector<FoundWork> works;
};

/// Finds the workpieces of a drawing in whole frames of a scene at rest. Reference lamps are looked
/// for in the frame `of_lamps` where `frames` are exposed for the marks. Throws WorkError when
/// there is none, when it moves, when it fits in several ways and not all of them are wanted, and
/// when its marks contradict the drawing.
std::vector<FoundWork> find_work(const std::vector<Frame>& frames, const VisionCalibration& vision,
                                 const std::vector<Fiducial>& drawing, const WorkSettings& settings,
                                 const std::optional<Frame>& of_lamps = {});

/// Numbers works by columns along x, and within a column along y. One that lies less than half a
/// drawing beside its neighbour is of its column, so that a look again numbers them alike.
void number_works(std::vector<FoundWork>& works, const std::vector<Fiducial>& drawing);

/// Returns by how much lamps are shifted beside marks by their rims and glow: standard deviation
/// per axis near a place, metres; 0 where it is not seen. Reflections and smears shift a centre by
/// up to 0.026 px, rms (doc/lamps.md), and a map takes the mean of it for the lens's.
double lamps_shift_sigma(const Workplane& plane, const Eigen::Vector2d& p_B);

/// A bar with two marks as it is seen, base frame, metres.
struct BarSight {
  std::array<Eigen::Vector2d, 2> p_B{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double length{0.0};  ///< between its marks
  double sigma{0.0};   ///< of the length, by the marks' noise and the doubts about height and lens
};

/// Measures every bar with such marks, which are about as far apart as drawn, in whole frames of a
/// scene at rest. Throws WorkError when there is none.
std::vector<BarSight> see_bars(const std::vector<Frame>& frames, const VisionCalibration& vision,
                               const std::vector<Fiducial>& bar);

/// Measures everything in whole frames of a scene at rest that looks like this mark, wherever it
/// is. Returns places as FoundFiducial has them, without residuals; the id of a tag is its number.
std::vector<FoundFiducial> see_like(const std::vector<Frame>& frames,
                                    const VisionCalibration& vision, const Fiducial& form);

/// Measures marks whose places in the base frame are known, each near its own, in whole frames of a
/// scene at rest; those that are not seen are left out. Throws WorkError where two are seen near
/// one place.
std::vector<FoundFiducial> see_marks(const std::vector<Frame>& frames,
                                     const VisionCalibration& vision,
                                     const std::vector<Fiducial>& marks_B);

/// What a later look at a workpiece shows.
struct WorkMotion {
  std::vector<std::string> hidden;     ///< marks that are not seen, as under the arm
  Eigen::Vector2d shift{0.0, 0.0};     ///< of the seen marks' middle, metres
  double turn{0.0};                    ///< radians; 0 where one mark is seen
  std::optional<std::string> moved{};  ///< in words, where that is beyond what the looks allow
};

/// Looks at the marks of a workpiece again, each where it was; `of_lamps` is as for find_work().
WorkMotion look_again(const std::vector<Frame>& frames, const VisionCalibration& vision,
                      const FoundWork& work, const std::optional<Frame>& of_lamps = {});

}  // namespace planar
