#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/purpose.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar {

/// The tool at a place of a recording, as the camera saw it in one frame or at one rest.
struct PoseSight : Observation {
  std::string id;
  Purpose plan{Purpose::kTrain};
  Eigen::Vector3d theta{0.0, 0.0, 0.0};  ///< commanded joint angles, radians
};

/// The tool at a place that the tracker watched as well, with the mean of its readings there.
struct ToolSight : PoseSight {
  /// Number of the joint-3 sweep of this place; the places of one sweep share the end point.
  /// kNoSweep for places outside a sweep.
  int sweep{kNoSweep};
  Eigen::Vector3d p_reflector_B{0.0, 0.0, 0.0};  ///< metres
  double sigma_tracker{0.0};                     ///< per axis, metres

  static constexpr int kNoSweep = -1;
};

/// The lamps in one frame.
struct LampSight : PoseSight {
  std::string fault;  ///< why the lamps were not found; empty when they were
};

/// One reading of the reflector on the tool, in the base frame.
struct ToolReading {
  std::string id;
  double t_s{0.0};
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
  double sigma{0.0};  ///< per axis, metres
};

enum class PairBy { kId, kTime };

struct Pairing {
  std::vector<ToolSight> sights;      ///< in the order of the frames
  std::vector<PoseSight> unattended;  ///< places of plan pose, in the order of the frames
  std::vector<Rejection> rejected;
};

/// Pairs frames and readings by id or by time stamp. The good frames of one id are averaged, and so
/// are its readings; by time these are the readings within half a second of its frames, each given
/// to the nearest id. Places of plan sweep3 with the same commanded joints 1 and 2 form a sweep.
/// Places of plan `pose` need no reading; if they have one, it is not used. Rejected, with the
/// reason, are ids without a good frame or reading, readings without a frame, and places where the
/// arm was not at rest because frames or readings disagree. Throws InputError naming values that
/// are not finite.
Pairing pair_sights(const std::vector<LampSight>& frames, const std::vector<ToolReading>& readings,
                    PairBy by);

/// Returns the places of these frames as poses that no tracker watched, whatever their plans.
/// Rejected, with the reason, are places without a good frame and where the arm was not at rest.
/// Throws InputError naming values that are not finite.
Pairing unattended_sights(const std::vector<LampSight>& frames);

/// Returns the end point by the tracker, reflector - R(phi) p_TS, base plane, metres. `phi` is the
/// direction of the lamps, radians.
Eigen::Vector2d end_point_by_tracker(const ToolOffsets& tool, const ToolSight& sight, double phi);

/// Throws InputError when readings were assigned to the wrong places. A cubic function of the
/// lamps' pixels and direction predicts the reflector's position; for right pairs its median error
/// is below 2 % of the field. Where it is larger and the pairing is by id, shifts by up to three
/// rows are tried; the error names the shift with which the readings follow the lamps. Where no
/// shift helps, readings are refused only from a quarter of the field on, because no camera bends
/// the plane by that. Too few places are not checked.
void require_reading_order(const std::vector<ToolSight>& sights, PairBy by);

/// Removes places at which the tracker repeated the reading of the place before exactly, although
/// the lamps had moved. Returns each with the reason.
std::vector<Rejection> take_out_frozen(std::vector<ToolSight>& sights);

}  // namespace planar
