#pragma once

#include <vector>

#include "planar_servo/calibration/workplane_calibration.h"

namespace planar {

/// The tool at rest at a place that no tracker watched, and where the arm was sent.
struct SentSight {
  PoseSight sight;
  Eigen::Vector2d p_sent_B{0.0, 0.0};  ///< the end point by the cell file's arm, metres
};

/// Finds X_WC and the end point on the tool without a tracker. Height and tilt of the plane come
/// from a board laid on it (X_CG), whose points lie `points_height` above the lamps' plane (metres,
/// negative below); place and turn are those with which the end points as seen lie nearest to where
/// the arm was sent, by least squares over p_sent = R (m + R(phi) p_TP) + t with the lamps' middle
/// m. The reflector stays unknown. Places that stand out from the others are left out.
///
/// Throws InputError for less than 6 places, for lamps that point in nearly the same direction
/// everywhere, for places seen in another size than the arm has (by 5 %), an rms above 2 % of the
/// field, and when more than a third of the places stands out.
WorkplaneFit fit_workplane_to_arm(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                  const std::vector<SentSight>& sights, double points_height);

}  // namespace planar
