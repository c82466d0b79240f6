#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/report/axis.h"

namespace planar {

std::vector<Eigen::Vector2d> in_mm(const std::vector<Eigen::Vector2d>& metres);

std::vector<double> lengths_of(const std::vector<Eigen::Vector2d>& vectors);

/// Returns the x of every vector and the y of every vector in one list.
std::vector<double> components_of(const std::vector<Eigen::Vector2d>& vectors);

/// The axes of a panel of places in the base frame, in millimetres: x to the right, y up.
struct FieldAxes {
  Axis x, y;
};

/// Returns axes over places in millimetres, with room for arrows at the edge.
FieldAxes axes_over_places(const std::vector<Eigen::Vector2d>& places_mm);

}  // namespace planar
