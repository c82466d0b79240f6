#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/workpiece/fiducials.h"

namespace planar {

/// Where a bar lies: its middle in the base frame, metres, and its direction modulo half a turn,
/// radians.
struct BarStance {
  Eigen::Vector2d middle_B{0.0, 0.0};
  double turn{0.0};
};

/// Returns `count` stances that spread a bar of this length over a disc round the base, at evenly
/// spread turns; those that would leave it lie across its middle.
std::vector<BarStance> bar_stances(double radius, double length, std::size_t count);

/// Returns that of the stances which is farthest from all that were taken: turns count by what they
/// move the bar's ends.
BarStance next_stance(const std::vector<BarStance>& wanted, const std::vector<BarStance>& taken,
                      double length);

/// How many places of a bar are measured.
constexpr std::size_t kBarPlaces = 8;

/// Returns the pictures of a bar in a folder, which may not exist yet.
std::vector<std::filesystem::path> bar_pictures(const std::filesystem::path& folder);

/// Takes pictures of a bar, place by place, guiding the person who lays it, until there are as many
/// as wanted or the person ends it; those that the folder has count. Unattended, it takes one. Each
/// is looked at: the bar must be seen in it, and lie elsewhere than before. Returns all pictures of
/// the folder. Throws WorkError without a picture, and unattended without a bar in a new place.
std::vector<std::filesystem::path> record_bar(const std::vector<Fiducial>& bar,
                                              const VisionCalibration& vision,
                                              const Workspace& workspace, std::size_t wanted,
                                              const std::filesystem::path& folder,
                                              FrameSource& camera, Operator& person,
                                              const std::function<bool()>& stop);

}  // namespace planar
