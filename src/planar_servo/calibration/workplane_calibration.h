#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/geometry/lens/camera_model.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar {

/// A point of the tool while joint 3 alone turns. `sweep` numbers the positions of the end point.
struct SweepPoint {
  int sweep{0};
  double phi{0.0};
  Eigen::Vector2d p{0.0, 0.0};  ///< base plane, metres
};

struct SweepOffset {
  Eigen::Vector2d offset{0.0, 0.0};  ///< the point in the turning tool, from the axis, metres
  double variance{0.0};              ///< of each coordinate, m^2
  std::vector<double>
      residuals;  ///< distances from the fitted positions, metres, in the points' order
};

/// Fits p_i = P_sweep(i) + R(phi_i) offset by least squares, with a free position P of the axis in
/// each sweep. With z = p - mean p and C = R - mean R per sweep, sum C^T C = s I and offset = sum
/// C^T z / s. Throws InputError when the angles vary so little that the offset would be less
/// certain than a single reading (s < 1), and when no place is left to show the points' noise.
SweepOffset fit_sweep_offset(const std::vector<SweepPoint>& points);

/// The pose of the camera over the plane of the lamps, and the offsets of the tool in it.
struct WorkplaneFit {
  Pose X_WC{Pose::Identity()};
  /// Covariance of (dc, dw), where the pose is (c + dc, exp(dw) R); m and rad.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
  ToolOffsets tool;
  double rms{0.0};  ///< of the distances from vision to tracker over the observations used, metres
  std::size_t n_used{0};
  int absorbed{0};  ///< degrees of freedom of X_WC that the pairs determined
  std::vector<Rejection> rejected;
};

/// Fits X_WC with 6 degrees of freedom: height and tilt of the lamps' plane come from the pairs,
/// too. Gauss-Newton steps minimise the distances in the plane between the reflector by vision and
/// by the tracker, in turn with the tool's offsets, which the joint-3 sweeps alone determine
/// (fit_sweep_offset). Observations far beyond the robust scatter of all are left out, in rounds.
///
/// Throws InputError for values that are not finite, fewer than 6 observations, collinear
/// positions, sweeps that do not determine the offsets, positions that only a mirrored camera would
/// see, more than a third of the observations rejected or an rms above 2 % of the field. Throws
/// WorkError when the fit does not converge.
WorkplaneFit fit_workplane_to_pairs(const CameraModel& camera,
                                    const std::vector<ToolSight>& sights);

/// Fits position and turn in the plane to the pairs, rigidly and without scale. Height and tilt of
/// the plane come from a board laid once or several times (X_CG), whose points lie `points_height`
/// above the lamps' plane (metres, negative below); their covariance is that of the mean over the
/// views, and zero for a single view. Throws like fit_workplane_to_pairs(), and InputError when the
/// camera's heights by board and by tracker differ by more than 5 %.
WorkplaneFit fit_workplane_to_board(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                    const std::vector<ToolSight>& sights,
                                    double points_height = 0.0);

/// The tool at rest at a place that no tracker watched, and the position to which the arm was sent.
struct SentSight {
  PoseSight sight;
  Eigen::Vector2d p_sent_B{0.0, 0.0};  ///< the end point by the cell file's arm, metres
};

/// Finds X_WC and the end point on the tool without a tracker. Height and tilt of the plane come
/// from a laid board as in fit_workplane_to_board(); position and turn in the plane are those that
/// bring the end points as seen nearest to where the arm was sent, by least squares over p_sent =
/// R (m + R(phi) p_TP) + t with the lamps' middle m. The reflector stays unknown. Outlying places
/// are left out.
///
/// Throws InputError for fewer than 6 places, for lamps that point in nearly the same direction
/// everywhere, for a scale that differs from the arm's by more than 5 %, an rms above 2 % of the
/// field, and when more than a third of the places are left out.
WorkplaneFit fit_workplane_to_arm(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                  const std::vector<SentSight>& sights, double points_height);

}  // namespace planar
