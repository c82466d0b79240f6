#pragma once

#include <Eigen/Core>
#include <functional>
#include <type_traits>
#include <vector>

#include "planar_servo/report/axis.h"

namespace planar {

/// Returns `of` of every element: its member, or a function's value.
template <typename Elements, typename Of>
auto each(const Elements& elements, Of of) {
  std::vector<std::decay_t<decltype(std::invoke(of, *std::begin(elements)))>> all;
  for (const auto& element : elements) all.push_back(std::invoke(of, element));
  return all;
}

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
