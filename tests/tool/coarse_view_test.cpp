#include "planar_servo/geometry/tool/tips.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "planar_servo/base/core/pose.h"

namespace planar {
namespace {

constexpr double kNoisePx = 0.3;
constexpr double kFewPixels = 10.0 * kNoisePx;
constexpr double kExactPx = 1e-6;  ///< algebra on coordinates of 1e3 px

/// A camera above the plane: image y runs down, so the map mirrors; a tilt gives perspective.
Eigen::Matrix3d true_map() {
  Eigen::Matrix3d H;
  H << 4200.0, 130.0, 2560.0, 120.0, -4180.0, 2550.0, 0.06, -0.04, 1.0;
  return H;
}

std::vector<CoarseViewRow> sights(int n, double noise_px, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<CoarseViewRow> rows;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d p{place(random), place(random)};
    const Eigen::Vector2d error{noise(random), noise(random)};
    rows.push_back({p, (true_map() * p.homogeneous()).hnormalized() + noise_px * error});
  }
  return rows;
}

double worst_error_px(const CoarseView& view) {
  double worst = 0.0;
  for (const CoarseViewRow& row : sights(50, 0.0)) {
    worst = std::max(worst, (view.pixel(row.p).value() - row.uv_px).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("A homography is recovered from clean sights") {
  for (unsigned seed = 0; seed < 100; ++seed)
    CHECK(worst_error_px(fit_coarse_view(sights(8, 0.0, seed)).value()) < kExactPx);
}

TEST_CASE("Three sights give an affine map through them") {
  const std::vector<CoarseViewRow> rows = sights(3, 0.0);
  const CoarseView view = fit_coarse_view(rows).value();
  for (const CoarseViewRow& row : rows) {
    CHECK((view.pixel(row.p).value() - row.uv_px).norm() < kExactPx);
  }
}

TEST_CASE("The tool's direction is that of a short step along it, mirrored as the image is") {
  const CoarseView view = fit_coarse_view(sights(30, 0.0)).value();
  const Eigen::Vector2d p(0.2, -0.3);
  for (const double phi : {0.0, 0.7, 2.5, -1.9}) {
    const Eigen::Vector2d step = 1e-6 * rotation2d(phi).col(0);
    const Eigen::Vector2d moved = view.pixel(p + step).value() - view.pixel(p - step).value();
    CHECK((view.direction(p, phi).value() - moved.normalized()).norm() < 1e-5);
  }
  CHECK(view.direction(p, 1.5707963).value().y() < -0.9);
}

TEST_CASE("A third of wrong sights does not bend the coarse view") {
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::vector<CoarseViewRow> rows = sights(12, kNoisePx, seed);
    const std::vector<CoarseViewRow> wrong = sights(36, kNoisePx, seed + 100);
    for (std::size_t i = 0; i < rows.size(); i += 3) rows[i].uv_px = wrong[24 + i].uv_px;
    const CoarseView view = fit_coarse_view(rows).value();
    for (std::size_t i = 1; i < rows.size(); i += 3)
      CHECK((view.pixel(rows[i].p).value() - rows[i].uv_px).norm() < kFewPixels);
  }
}

TEST_CASE("Too few, collinear or non-finite sights give no coarse view") {
  CHECK_FALSE(fit_coarse_view(sights(2, 0.0)));
  std::vector<CoarseViewRow> line;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d p(0.1 * i, 0.05 * i);
    line.push_back({p, (true_map() * p.homogeneous()).hnormalized()});
  }
  CHECK_FALSE(fit_coarse_view(line));
  std::vector<CoarseViewRow> rows = sights(3, 0.0);
  rows[1].uv_px.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(fit_coarse_view(rows));
}

TEST_CASE("Nothing is seen beyond the horizon") {
  const CoarseView view(true_map());
  CHECK_FALSE(view.pixel({-20.0, 0.0}));
  CHECK_FALSE(view.direction({-20.0, 0.0}, 0.0));
}

}  // namespace planar
