#include "planar_servo/lamps/rim/outline.h"

#include <Eigen/LU>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Returns the product of two complex numbers.
Eigen::Vector2d turned(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {a.x() * b.x() - a.y() * b.y(), a.x() * b.y() + a.y() * b.x()};
}

/// Returns the symmetric square root of a symmetric positive definite matrix.
Eigen::Matrix2d square_root(const Eigen::Matrix2d& m) {
  const double root = std::sqrt(m.determinant());
  return (m + root * Eigen::Matrix2d::Identity()) / std::sqrt(m.trace() + 2.0 * root);
}

}  // namespace

Outline outline_of(const Blob& blob) {
  Outline outline;
  outline.center = blob.uv_px;
  outline.axes = square_root(4.0 * blob.second_moments_px2);
  return outline;
}

double Outline::diameter() const {
  return 2.0 * std::sqrt(axes.determinant());
}

void Outline::change(const Terms& terms) {
  center += terms.head<2>();
  axes(0, 0) += terms[2];
  axes(0, 1) += terms[3];
  axes(1, 0) += terms[3];
  axes(1, 1) += terms[4];
  waves = terms.tail<kWaveTerms>();
}

// These depend only on the number of normals.
void Normals::spread_harmonics(int count) {
  move.resize(Outline::kTerms, count);
  harmonics.resize(kHarmonics, count);
  const double step = 2.0 * kPi / count;
  const Eigen::Vector2d turn(std::cos(step), std::sin(step));
  Eigen::Vector2d ray(1.0, 0.0);
  for (int k = 0; k < count; ++k, ray = turned(ray, turn)) {
    const Eigen::Vector2d twice = turned(ray, ray);
    harmonics.col(k) << 1.0, ray, twice;
    Eigen::Vector2d wave = turned(twice, ray);
    for (int term = Outline::kShapeTerms; term < Outline::kTerms; term += 2) {
      move.col(k).segment<2>(term) = wave;
      wave = turned(wave, ray);
    }
  }
}

void Normals::spread(const Outline& outline, int count) {
  if (harmonics.cols() != count) spread_harmonics(count);
  foot.resize(2, count);
  direction.resize(2, count);
  arc_px.resize(count);
  const double step = 2.0 * kPi / count;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector2d ray = harmonics.col(k).segment<2>(1);
    const Eigen::Vector2d tangent = outline.axes * Eigen::Vector2d(-ray.y(), ray.x());
    const double speed = tangent.norm();
    const Eigen::Vector2d n = Eigen::Vector2d(tangent.y(), -tangent.x()) / speed;
    foot.col(k) = outline.center + outline.axes * ray;
    direction.col(k) = n;
    arc_px[k] = speed * step;
    move.col(k).head<Outline::kShapeTerms>() << n, n.x() * ray.x(),
        n.x() * ray.y() + n.y() * ray.x(), n.y() * ray.y();
  }
}

PerNormal Normals::moved(const Outline::Terms& terms) const {
  PerNormal moves =
      move.topRows<Outline::kShapeTerms>().transpose() * terms.head<Outline::kShapeTerms>();
  const Outline::Waves waves = terms.tail<Outline::kWaveTerms>();
  if (!waves.isZero(0.0)) moves += move.bottomRows<Outline::kWaveTerms>().transpose() * waves;
  return moves;
}

PerNormal Normals::waves(const Outline& outline) const {
  if (outline.waves.isZero(0.0)) return PerNormal::Zero(count());
  return move.bottomRows<Outline::kWaveTerms>().transpose() * outline.waves;
}

}  // namespace planar
