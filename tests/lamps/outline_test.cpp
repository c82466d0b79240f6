#include "planar_servo/lamps/rim/outline.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kAlgebra = 1e-12;

Outline oblique() {
  Outline outline;
  outline.center = {50.0, 40.0};
  outline.axes << 21.0, 3.0, 3.0, 14.0;
  return outline;
}

TEST_CASE("Normals stand on the ellipse, at right angles to it, pointing outwards") {
  const Outline outline = oblique();
  Normals normals;
  normals.spread(outline, 100);
  const Eigen::Matrix2d shape = (outline.axes * outline.axes).inverse();
  for (int k = 0; k < normals.count(); ++k) {
    const Eigen::Vector2d d = normals.foot.col(k) - outline.center, n = normals.direction.col(k);
    CHECK(d.dot(shape * d) == Approx(1.0).margin(kAlgebra));
    const Eigen::Vector2d gradient = (shape * d).normalized();
    CHECK((gradient - n).norm() < kAlgebra);
  }
}

TEST_CASE("Normals' arcs add up to the length of the ellipse") {
  Normals normals;
  Outline circle;
  circle.axes *= 20.0;
  normals.spread(circle, 64);
  CHECK(normals.arc_px.sum() == Approx(2.0 * kPi * 20.0).epsilon(kAlgebra));
}

/// How far outside the ellipse a point lies, to first order.
double distance(const Outline& outline, const Eigen::Vector2d& p) {
  const Eigen::Vector2d q = outline.axes.inverse() * (p - outline.center);
  const Eigen::Vector2d gradient = outline.axes.inverse() * q;
  return (q.squaredNorm() - 1.0) / (2.0 * gradient.norm());
}

TEST_CASE("Normals' moves are the derivatives of the ellipse along the normals") {
  constexpr double kStep = 1e-6, kFiniteDifference = 1e-5;
  const Outline outline = oblique();
  Normals normals;
  normals.spread(outline, 40);
  for (int term = 0; term < Outline::kShapeTerms; ++term) {
    Outline moved = outline;
    Outline::Terms change = Outline::Terms::Zero();
    change[term] = kStep;
    moved.change(change);
    for (int k = 0; k < normals.count(); ++k) {
      // The ellipse has moved outwards by what the old foot lies inside it.
      const double outwards = -distance(moved, normals.foot.col(k)) / kStep;
      CHECK(normals.move(term, k) == Approx(outwards).margin(kFiniteDifference));
    }
  }
}

TEST_CASE("Normals carry the harmonics of the angle, also after another count") {
  Normals normals;
  normals.spread(oblique(), 36);
  normals.spread(oblique(), 50);
  for (int k = 0; k < normals.count(); ++k) {
    const double angle = 2.0 * kPi * k / 50.0;
    CHECK(normals.harmonics(3, k) == Approx(std::cos(2.0 * angle)).margin(kAlgebra));
    CHECK(normals.move(Outline::kShapeTerms, k) == Approx(std::cos(3.0 * angle)).margin(kAlgebra));
    CHECK(normals.move(Outline::kTerms - 1, k) == Approx(std::sin(9.0 * angle)).margin(kAlgebra));
  }
}

}  // namespace
}  // namespace planar
