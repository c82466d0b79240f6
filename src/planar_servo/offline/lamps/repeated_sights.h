#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/files/tables/lamp_table.h"

namespace planar {

/// A lamp in one of several images of a place at which the arm rested.
struct RepeatedSight {
  double at{0.0};                    ///< the row of its image, from 1
  Eigen::Vector2d off_px{0.0, 0.0};  ///< from the mean of its place, as large as one image is off
  Eigen::Vector2d pull{0.0, 0.0};    ///< the same per axis, divided by the stated deviation
};

/// Returns every lamp of the images that share an id with others. What the mean takes of the
/// scatter is given back.
std::vector<RepeatedSight> repeated_sights(const std::vector<LampRow>& rows);

}  // namespace planar
