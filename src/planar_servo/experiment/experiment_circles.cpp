#include "planar_servo/experiment/experiment_circles.h"

#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kPaperLeast_mm = 60.0, kPaperMost_mm = 540.0;

}  // namespace

ExperimentCircles circles_within(const Workspace& workspace) {
  const double least_mm = workspace.radius_min_m / kMillimetre;
  const double most_mm = workspace.radius_max_m / kMillimetre;
  const double scale = (most_mm - least_mm) / (kPaperMost_mm - kPaperLeast_mm);
  const auto whole = [](double length_mm) { return static_cast<int>(std::lround(length_mm)); };
  const auto stretched = [&](double radius_mm) {
    return least_mm + scale * (radius_mm - kPaperLeast_mm);
  };
  ExperimentCircles circles;
  for (int& radius_mm : circles.check_mm) radius_mm = whole(stretched(radius_mm));
  for (int& radius_mm : circles.run_mm) radius_mm = whole(stretched(radius_mm));
  circles.sweep_mm = whole(stretched(circles.sweep_mm));
  circles.rim_mm = whole(scale * circles.rim_mm);
  circles.control_mm = whole(scale * circles.control_mm);
  const double diagonal = std::sqrt(2.0);
  circles.control_offset_mm = whole(stretched(diagonal * circles.control_offset_mm) / diagonal);
  return circles;
}

std::vector<Eigen::Vector2d> circle_points(const Eigen::Vector2d& center, double radius,
                                           int count) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    points.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

}  // namespace planar
