#pragma once

#include <Eigen/Core>
#include <vector>

namespace planar {

/// Errors of one pose that was commanded again and again: attained minus commanded place, metres.
using PoseErrors = std::vector<Eigen::Vector2d>;

/// Accuracy and repeatability of a pose, metres or radians.
struct PoseAccuracy {
  double accuracy{0.0};       ///< AP
  double repeatability{0.0};  ///< RP
};

// The figures of ISO 9283:1998 in the plane: z is left out. All throw std::invalid_argument for
// empty sets.

/// Returns the barycentre of the errors.
Eigen::Vector2d barycentre(const PoseErrors& errors);

/// Returns AP = |mean of the errors| and RP = mean l + 3 S_l [ISO 9283:1998, 7.2], with the
/// distances l from the barycentre and their standard deviation S_l over n - 1. RP is NaN for fewer
/// than two errors.
PoseAccuracy pose_accuracy(const PoseErrors& errors);

/// Returns the same for an angle: AP = |mean|, RP = 3 S over n - 1, radians.
PoseAccuracy angle_accuracy(const std::vector<double>& errors);

/// Returns the multi-directional pose accuracy variation vAP: the greatest distance between the
/// barycentres of one pose that was approached from several directions [ISO 9283:1998, 7.2.4].
double direction_variation(const std::vector<PoseErrors>& by_direction);

}  // namespace planar
