#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/calibration/tool_sight.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

/// The plane of the lamps in the camera's view, and the tool that moves in it.
struct WorkplaneFit {
  Pose X_WC{Pose::Identity()};
  /// Of (translation, rotation): X_WC is known up to (c + dc, exp(dw) R), in m and rad.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
  ToolOffsets tool;
  double rms{0.0};  ///< of the distances from vision to tracker over the rows used, metres
  std::size_t n_used{0};
  int absorbed{0};  ///< degrees of freedom that the pairs gave to X_WC and so took from E
  std::vector<Rejection> rejected;
};

/// Fits X_WC (6 degrees of freedom: the height and tilt of the lamps' plane come out of the pairs)
/// by Gauss-Newton on the distances in the plane between the reflector as vision and as the tracker
/// saw it, in turn with the tool's offsets, which the joint-3 sweeps give alone (see
/// fit_sweep_offset). Sights far beyond the robust scatter of all are left out, in rounds.
///
/// Throws InputError for values that are not finite, fewer than 6 sights, collinear positions,
/// sweeps that do not determine the offsets, positions that only a mirrored camera would see, more
/// than a third of the sights rejected or an rms above 2 % of the field; WorkError when the fit
/// does not converge.
WorkplaneFit fit_workplane_to_pairs(const CameraModel& camera,
                                    const std::vector<ToolSight>& sights);

/// The same with height and tilt of the plane from a board laid on it (one or more X_CG): the pairs
/// give only place and turn in the plane, by a rigid fit without scale. The covariance of height
/// and tilt is that of the mean over the views; a single view leaves it zero.
WorkplaneFit fit_workplane_to_board(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                    const std::vector<ToolSight>& sights);

}  // namespace planar
