#include "planar_servo/report/places.h"

#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/report/panel.h"

namespace planar {

std::vector<Eigen::Vector2d> circle_of(const Eigen::Vector2d& center, double radius, int pieces) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = 2.0 * kPi * i / pieces;
    points.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

std::vector<Eigen::Vector2d> in_mm(const std::vector<Eigen::Vector2d>& metres) {
  return each(metres, [](const Eigen::Vector2d& p) { return Eigen::Vector2d(p / kMillimetre); });
}

std::vector<double> lengths_of(const std::vector<Eigen::Vector2d>& vectors) {
  return each(vectors, [](const Eigen::Vector2d& vector) { return vector.norm(); });
}

std::vector<double> components_of(const std::vector<Eigen::Vector2d>& vectors) {
  std::vector<double> components;
  components.reserve(2 * vectors.size());
  for (const Eigen::Vector2d& vector : vectors) components.push_back(vector.x());
  for (const Eigen::Vector2d& vector : vectors) components.push_back(vector.y());
  return components;
}

FieldAxes axes_over_places(const std::vector<Eigen::Vector2d>& places_mm) {
  // At each end, as a share of the wider range: the longest arrow in a panel that is drawn over it.
  constexpr double kRoomForArrows = kLongestArrow / (kPanelWidth - 2.0 * kLongestArrow);
  Eigen::Vector2d least = places_mm.at(0), most = least;
  for (const Eigen::Vector2d& p : places_mm) {
    least = least.cwiseMin(p);
    most = most.cwiseMax(p);
  }
  const double range = (most - least).maxCoeff();
  const double room = range > 0.0 ? kRoomForArrows * range : 1.0;
  return {{"x, mm", least.x() - room, most.x() + room},
          {"y, mm", least.y() - room, most.y() + room}};
}

}  // namespace planar
