#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/base/core/each.h"
#include "planar_servo/report/axis.h"

namespace planar {

/// Returns a circle in equal pieces from its +x side on, where it ends as well.
std::vector<Eigen::Vector2d> circle_of(const Eigen::Vector2d& center, double radius,
                                       int pieces = 120);

std::vector<Eigen::Vector2d> in_mm(const std::vector<Eigen::Vector2d>& metres);

std::vector<double> lengths_of(const std::vector<Eigen::Vector2d>& vectors);

/// Returns the x of every vector and the y of every vector in one list.
std::vector<double> components_of(const std::vector<Eigen::Vector2d>& vectors);

/// Returns axes over places in millimetres, with room for arrows at the edge.
FieldAxes axes_over_places(const std::vector<Eigen::Vector2d>& places_mm);

}  // namespace planar
