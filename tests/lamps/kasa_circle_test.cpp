#include "planar_servo/lamps/paper_center.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

constexpr double kExact = 1e-9;  // k epsilon, at coordinates of thousands of pixels

TEST_CASE("kasa_circle gives back the circle of exact points, far from the origin as well") {
  const Eigen::Vector2d center(4711.25, 3021.5);
  std::vector<Eigen::Vector2d> points;
  for (const double angle : {0.1, 0.9, 2.0, 2.2, 4.5}) {
    points.push_back(center + 21.5 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  const std::optional<Circle> circle = kasa_circle(points);
  REQUIRE(circle);
  CHECK((circle->center - center).norm() < kExact * center.norm());
  CHECK(circle->radius == Approx(21.5).margin(kExact * center.norm()));
}

TEST_CASE("kasa_circle solves Kasa's equations in sums C, D, E, G, H for points off any circle") {
  const std::vector<Eigen::Vector2d> points{{1, 0}, {0, 2}, {-1.5, 0}, {0, -1}, {1, 1}};
  const double N = 5.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p / N;
  double x = 0, y = 0, xx = 0, yy = 0, xy = 0, sx = 0, sy = 0, s = 0;
  for (const auto& p : points) {
    const Eigen::Vector2d d = p - mean;
    x += d.x(), y += d.y(), xx += d.x() * d.x(), yy += d.y() * d.y(), xy += d.x() * d.y();
    sx += d.squaredNorm() * d.x(), sy += d.squaredNorm() * d.y(), s += d.squaredNorm();
  }
  const double C = N * xx - x * x, D = N * xy - x * y, E = N * sx - s * x;
  const double G = N * yy - y * y, H = N * sy - s * y;
  const double a = (H * D - E * G) / (C * G - D * D), b = (E * D - H * C) / (C * G - D * D);
  const double c = -(s + a * x + b * y) / N;
  const std::optional<Circle> circle = kasa_circle(points);
  REQUIRE(circle);
  CHECK(circle->center.x() == Approx(mean.x() - a / 2.0));
  CHECK(circle->center.y() == Approx(mean.y() - b / 2.0));
  CHECK(circle->radius == Approx(0.5 * std::sqrt(a * a + b * b - 4.0 * c)));
}

TEST_CASE("kasa_circle is empty for too few points, points on a line and points all the same") {
  CHECK_FALSE(kasa_circle({}));
  CHECK_FALSE(kasa_circle({{0, 0}, {1, 1}}));
  CHECK_FALSE(kasa_circle({{0, 0}, {1, 2}, {2, 4}, {3, 6}}));
  CHECK_FALSE(kasa_circle({{5, 5}, {5, 5}, {5, 5}}));
}

}  // namespace
}  // namespace planar
