#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/calibration/tool_sight.h"
#include "planar_servo/lens/workplane.h"

namespace planar {

/// The lamps in one frame, and where the arm was commanded to be.
struct LampSight {
  std::string id;
  double t_s{0.0};
  std::string status;  ///< "ok", or why there are no lamps
  std::array<Eigen::Vector2d, 2> uv_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  std::string plan;
  Eigen::Vector2d theta12{0.0, 0.0};  ///< commanded angles of joints 1 and 2, radians
};

/// One reading of the reflector on the tool, taken to the base frame.
struct ToolReading {
  std::string id;
  double t_s{0.0};
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
  double sigma{0.0};  ///< per axis, metres
};

enum class PairBy { kId, kTime };

struct Pairing {
  std::vector<ToolSight> sights;  ///< in the frames' order
  std::vector<Rejection> rejected;
};

/// Brings frames and readings together, by id or by time stamp, never by row number. The good
/// frames of one id, and the readings that belong to it, are averaged; by time, those readings
/// within half a second of its frames, each given to the nearest id. Places of plan sweep3 with the
/// same commanded joints 1 and 2 form a sweep. Left out, with the reason: ids without a good frame
/// or a reading, readings of no frame, and places where frames or readings disagree because the arm
/// was not at rest. Throws InputError naming values that are not finite.
Pairing pair_sights(const std::vector<LampSight>& frames, const std::vector<ToolReading>& readings,
                    PairBy by);

/// The end point P in the base frame as vision and as the tracker saw it.
struct EndPointPair {
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d p_tracker{0.0, 0.0};
  double phi{0.0};
  double sigma_vision{0.0};   ///< per axis, from the lamps' pixel covariances, metres
  double sigma_tracker{0.0};  ///< per axis, metres
};

/// P by vision = middle of the lamps + R(phi) p_TP; by the tracker = reflector - R(phi) p_TS, with
/// phi from vision. Empty when a lamp's ray does not meet the plane.
std::optional<EndPointPair> end_points(const Workplane& workplane, const ToolOffsets& tool,
                                       const ToolSight& sight);

}  // namespace planar
