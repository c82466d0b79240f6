#include "planar_servo/lamps/rim/outline.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

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

namespace {

constexpr int kShape = Outline::kShapeTerms, kWaves = Outline::kWaveTerms;

template <int Terms>
OutlineFit fit_terms(const Normals& normals, const PerNormal& offset_px,
                     const PerNormal& information, double wave_variance_px2) {
  using Column = Eigen::Matrix<double, Terms, 1>;
  Eigen::Matrix<double, Terms, Terms> normal = Eigen::Matrix<double, Terms, Terms>::Zero();
  Eigen::Matrix<double, Terms, Terms + 1> right;  // of the terms, then of their covariance
  right << Column::Zero(), Eigen::Matrix<double, Terms, Terms>::Identity();
  for (int k = 0; k < normals.count(); ++k) {
    const Column move = normals.move.col(k).head<Terms>();
    const Column weighted = information[k] * move;
    normal.noalias() += weighted * move.transpose();
    right.col(0) += offset_px[k] * weighted;
  }
  if (Terms > kShape) normal.diagonal().tail(Terms - kShape).array() += 1.0 / wave_variance_px2;
  solve_positive_in_place(normal, right);
  OutlineFit fit;
  fit.terms.head<Terms>() = right.col(0);
  fit.covariance.topLeftCorner<Terms, Terms>() = right.template rightCols<Terms>();
  fit.has_waves = Terms > kShape;
  return fit;
}

PerNormal residuals(const Normals& normals, const PerNormal& offset_px, const OutlineFit& fit) {
  return offset_px - normals.moved(fit.terms);
}

double robust_sigma(const PerNormal& residual, const NormalFlags& use) {
  std::array<double, Normals::kMost> sizes;
  std::size_t n = 0;
  for (Eigen::Index k = 0; k < residual.size(); ++k)
    if (use[k]) sizes[n++] = std::abs(residual[k]);
  if (n == 0) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(sizes.begin(), middle, sizes.begin() + static_cast<std::ptrdiff_t>(n));
  return kNormalPerMad * *middle;
}

}  // namespace

OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2) {
  return wave_variance_px2 > 0.0
             ? fit_terms<Outline::kTerms>(normals, offset_px, information, wave_variance_px2)
             : fit_terms<kShape>(normals, offset_px, information, 0.0);
}

OutlineFit fit_outline(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information) {
  constexpr double kSigmas = 3.0, kLeastVariance_px2 = 1e-6;
  OutlineFit even = fit_outline(normals, offset_px, information, 0.0);
  // These are the residuals that each wave alone would explain.
  const auto waves = normals.move.bottomRows<kWaves>();
  const PerNormal weighted = information.cwiseProduct(residuals(normals, offset_px, even));
  const Outline::Waves score = waves * weighted, known = waves.cwiseAbs2() * information;
  const double excess = score.cwiseAbs2().cwiseQuotient(known).sum() - kWaves;
  if (!(excess > kSigmas * std::sqrt(2.0 * kWaves))) return even;
  const OutlineFit first = fit_outline(normals, offset_px, information, excess / known.sum());
  const double power =
      first.terms.tail<kWaves>().squaredNorm() + first.covariance.diagonal().tail<kWaves>().sum();
  return fit_outline(normals, offset_px, information, std::max(kLeastVariance_px2, power / kWaves));
}

ArcFit fit_without_arc(const Normals& normals, const PerNormal& offset_px,
                       const PerNormal& information, double wave_variance_px2) {
  constexpr int kStarts = 32;
  constexpr double kArc = 0.27;
  const int n = normals.count(), arc = static_cast<int>(kArc * n);
  auto normal = decltype(OutlineFit::covariance)::Zero().eval();
  normal.diagonal().tail<kWaves>().setConstant(1.0 / wave_variance_px2);
  Outline::Terms right = Outline::Terms::Zero();
  double squares = 0.0;
  const auto add = [&](int k, double weight) {
    const Outline::Terms move = normals.move.col(k);
    normal.noalias() += weight * move * move.transpose();
    right += weight * offset_px[k] * move;
    squares += weight * offset_px[k] * offset_px[k];
  };
  for (int k = arc; k < n; ++k) add(k, information[k]);
  ArcFit best;
  double least = 0.0;
  int first = 0, best_first = 0;
  for (int start = 0; start < kStarts; ++start) {
    for (; first < start * n / kStarts; ++first) {
      add(first, information[first]);
      add((first + arc) % n, -information[(first + arc) % n]);
    }
    auto factor = normal;
    Outline::Terms x = right;
    solve_positive_in_place(factor, x);
    const double cost = squares - x.dot(right);
    if (start > 0 && cost >= least) continue;
    least = cost;
    best_first = first;
    best.fit.terms = x;
  }
  best.use = information.array() > 0.0;
  for (int i = 0; i < arc; ++i) best.use[(best_first + i) % n] = false;
  return best;
}

NormalFlags agreeing(const Normals& normals, const PerNormal& offset_px, const OutlineFit& fit,
                     const Agreement& agreement, const NormalFlags& readable,
                     const NormalFlags& use) {
  constexpr double kSigmas = 4.5, kMostUncertain = 2.0;
  const Eigen::Index n = normals.count();
  const PerNormal residual = residuals(normals, offset_px, fit);
  const double sigma = std::max(agreement.least_sigma_px, robust_sigma(residual, use));
  const auto agrees = [&](Eigen::Index k) {
    double variance = sigma * sigma;
    if (!use[k]) {
      const auto move = normals.move.col(k);
      variance +=
          std::min(kMostUncertain * kMostUncertain * variance, move.dot(fit.covariance * move));
    }
    return readable[k] && residual[k] * residual[k] <= kSigmas * kSigmas * variance;
  };
  NormalFlags next(n);
  for (Eigen::Index k = 0; k < n; ++k) next[k] = use[k] && agrees(k);
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!use[k] || !next[k]) continue;
    for (const Eigen::Index step : {Eigen::Index{1}, n - 1}) {
      for (Eigen::Index i = (k + step) % n; !use[i] && !next[i] && agrees(i); i = (i + step) % n)
        next[i] = true;
    }
  }
  return clear_of_others(normals, next, agreement.blur_px);
}

NormalFlags clear_of_others(const Normals& normals, const NormalFlags& use, double blur_px) {
  constexpr double kReachOverBlur = 2.2;
  const Eigen::Index n = normals.count();
  const auto reach = std::max(
      Eigen::Index{1},
      static_cast<Eigen::Index>(std::lround(kReachOverBlur * blur_px / normals.arc_px.mean())));
  NormalFlags clear = use;
  for (Eigen::Index k = 0; k < n; ++k) {
    if (use[k]) continue;
    for (Eigen::Index i = -reach; i <= reach; ++i) clear[(k + n + i) % n] = false;
  }
  return clear;
}

}  // namespace planar
