#include "planar_servo/virtual_cell/virtual_lamps.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

using Outline = std::vector<Eigen::Vector2d>;

constexpr double kFloat = 1e-6;        // a pixel's coverage is stored as a float
constexpr double kSumOfFloats = 2e-4;  // some hundred rim pixels with that error
const cv::Rect kWindow(0, 0, 40, 40);

Outline circle(const Eigen::Vector2d& center, double radius, int points) {
  Outline outline;
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * kPi * i / points;
    outline.push_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

double area(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(0.5 * twice);
}

}  // namespace

TEST_CASE("A rectangle covers its pixels by the exact products of its sides") {
  const cv::Mat1f c =
      polygon_coverage({{2.25, 3.0}, {5.0, 3.0}, {5.0, 4.75}, {2.25, 4.75}}, kWindow);
  CHECK(c(3, 2) == Approx(0.25 * 0.5).margin(kFloat));
  CHECK(c(3, 3) == Approx(0.5).margin(kFloat));
  CHECK(c(4, 3) == Approx(1.0).margin(kFloat));
  CHECK(c(5, 5) == Approx(0.5 * 0.25).margin(kFloat));
  CHECK(c(3, 6) == Approx(0.0).margin(kFloat));
  CHECK(c(6, 3) == Approx(0.0).margin(kFloat));
}

TEST_CASE("A slanted edge cuts pixels by the exact trapezoids and triangles") {
  // The line y = x / 2 through the window's corner (-1/2, -1/2), area below it.
  const cv::Mat1f c = polygon_coverage({{-0.5, -0.5}, {3.5, 1.5}, {-0.5, 1.5}}, kWindow);
  CHECK(c(0, 0) == Approx(0.75).margin(kFloat));
  CHECK(c(0, 1) == Approx(0.25).margin(kFloat));
  CHECK(c(0, 2) == Approx(0.0).margin(kFloat));
  CHECK(c(1, 1) == Approx(1.0).margin(kFloat));
  CHECK(c(1, 2) == Approx(0.75).margin(kFloat));
  CHECK(c(1, 3) == Approx(0.25).margin(kFloat));
}

TEST_CASE("The sum of the coverage is the polygon's area in either sense of rotation") {
  Outline outline = circle({19.37, 20.81}, 16.7, 256);
  CHECK(cv::sum(polygon_coverage(outline, kWindow))[0] ==
        Approx(area(outline)).margin(kSumOfFloats));
  std::reverse(outline.begin(), outline.end());
  CHECK(cv::sum(polygon_coverage(outline, kWindow))[0] ==
        Approx(area(outline)).margin(kSumOfFloats));
}

TEST_CASE("A polygon moved by whole pixels covers the same pixels further on") {
  const cv::Mat1f here = polygon_coverage(circle({15.3, 14.6}, 9.2, 100), kWindow);
  const cv::Mat1f there = polygon_coverage(circle({22.3, 19.6}, 9.2, 100), kWindow);
  CHECK(cv::norm(here(cv::Rect(0, 0, 33, 35)), there(cv::Rect(7, 5, 33, 35)), cv::NORM_INF) <
        kFloat);
}

TEST_CASE("A window sees of a polygon what the whole sensor sees there") {
  const Outline outline = circle({19.4, 20.8}, 16.7, 200);
  const cv::Mat1f whole = polygon_coverage(outline, kWindow);
  for (const cv::Rect& part : {cv::Rect(10, 0, 12, 40), cv::Rect(0, 12, 40, 9),
                               cv::Rect(25, 25, 15, 15), cv::Rect(0, 0, 8, 8)})
    CHECK(cv::norm(polygon_coverage(outline, part), whole(part), cv::NORM_INF) < kFloat);
}

TEST_CASE("The window around an outline holds it and the margin") {
  const cv::Rect window = window_around({{2.2, 3.0}, {7.9, -1.5}}, 2.0);
  CHECK(window.x == 0);
  CHECK(window.y == -4);
  CHECK(window.br() == cv::Point(11, 6));
}

}  // namespace planar
