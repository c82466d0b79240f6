#include "planar_servo/report/places.h"

#include "planar_servo/base/core/units.h"
#include "planar_servo/report/panel.h"

namespace planar {

std::vector<Eigen::Vector2d> in_mm(const std::vector<Eigen::Vector2d>& metres) {
  std::vector<Eigen::Vector2d> mm;
  mm.reserve(metres.size());
  for (const Eigen::Vector2d& p : metres) mm.emplace_back(p / kMillimetre);
  return mm;
}

std::vector<double> lengths_of(const std::vector<Eigen::Vector2d>& vectors) {
  std::vector<double> lengths;
  lengths.reserve(vectors.size());
  for (const Eigen::Vector2d& vector : vectors) lengths.push_back(vector.norm());
  return lengths;
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
