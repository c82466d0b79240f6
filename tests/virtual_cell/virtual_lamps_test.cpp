#include "planar_servo/virtual_cell/virtual_lamps.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kDegreesApart = 15.0;
const Eigen::Vector2d kPlace(0.21, -0.33);

/// Where lamp 1's centre really is in the image.
Eigen::Vector2d true_center(const Truth& truth, const Pose& X_BT) {
  const Eigen::Vector2d& lamp = truth.tool.lamps_m[0];
  return *VirtualLens(truth.camera).project(X_BT * Eigen::Vector3d(lamp.x(), lamp.y(), 0.0), 0.0);
}

Light render(const Truth& truth, const Pose& X_BT) {
  return VirtualLamps(truth).render_all(X_BT, VirtualLens(truth.camera), 0.0).front();
}

/// Centroid of the grey levels within 50 px of a place, in pixels of the sensor.
Eigen::Vector2d grey_centroid(const Light& light, const Eigen::Vector2d& about) {
  Eigen::Vector2d sum(0.0, 0.0);
  double weight = 0.0;
  for (int r = 0; r < light.levels.rows; ++r)
    for (int c = 0; c < light.levels.cols; ++c) {
      const Eigen::Vector2d uv(light.window_px.x + c, light.window_px.y + r);
      if ((uv - about).norm() > 50.0) continue;
      sum += light.levels(r, c) * uv;
      weight += light.levels(r, c);
    }
  return sum / weight;
}

double level_at(const Light& light, const Eigen::Vector2d& uv) {
  const Eigen::Vector2d p = uv - Eigen::Vector2d(light.window_px.x, light.window_px.y);
  const int c = static_cast<int>(std::floor(p.x())), r = static_cast<int>(std::floor(p.y()));
  const double x = p.x() - c, y = p.y() - r;
  return (1 - y) * ((1 - x) * light.levels(r, c) + x * light.levels(r, c + 1)) +
         y * ((1 - x) * light.levels(r + 1, c) + x * light.levels(r + 1, c + 1));
}

/// Centre of the contour at half the middle's level.
Eigen::Vector2d half_level_center(const Light& light, const Eigen::Vector2d& about) {
  constexpr int kRays = 360;
  const double half = 0.5 * level_at(light, about);
  Eigen::Vector2d shift(0.0, 0.0);
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector2d n = rotation2d(2.0 * kPi * i / kRays).col(0);
    double radius = 5.0;
    while (level_at(light, about + radius * n) > half) radius += 0.005;
    shift += 2.0 / kRays * radius * n;
  }
  return about + shift;
}

}  // namespace

TEST_CASE("An even lamp's light is its peak times its ellipse, at the true centre") {
  Truth truth = test::evenly_lit_truth(1);
  truth.lamps[1].peak_level = 0.0;
  const Pose X_BT = test::tool_pose(kPlace, 0.4);
  const Light light = render(truth, X_BT);
  const Eigen::Vector2d center = true_center(truth, X_BT);

  const VirtualLens lens(truth.camera);
  const Eigen::Vector2d& place = truth.tool.lamps_m[0];
  const auto rim_at = [&](double x, double y) {
    const double radius = 0.5 * truth.lamps[0].diameter_m;
    return *lens.project(X_BT * Eigen::Vector3d(place.x() + radius * x, place.y() + radius * y, 0),
                         0.0);
  };
  const Eigen::Vector2d a = 0.5 * (rim_at(1, 0) - rim_at(-1, 0));
  const Eigen::Vector2d b = 0.5 * (rim_at(0, 1) - rim_at(0, -1));
  const double ellipse_px2 = kPi * std::abs(a.x() * b.y() - a.y() * b.x());
  constexpr double kPolygon = 2e-4;  // 256 chords lose 1e-4 of a circle's area
  CHECK(cv::sum(light.levels)[0] ==
        Approx(truth.lamps[0].peak_level * ellipse_px2).epsilon(kPolygon));

  constexpr double kEccentricityPx = 0.01;  // of a lamp of 34 px at 14 degrees
  CHECK((grey_centroid(light, center) - center).norm() < kEccentricityPx);
}

TEST_CASE("The glow moves the apparent centre by at least 0.1 px rms over the field") {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const Truth truth = draw_truth(seed);
    std::vector<double> grey_px, half_level_px;
    for (double angle = 0.0; angle < 6.0; angle += 0.5) {
      const double reach = 0.2 + 0.05 * angle;
      const Pose X_BT = test::tool_pose(reach * rotation2d(angle).col(0), 2.0 * angle);
      const Light light = render(truth, X_BT);
      const Eigen::Vector2d center = true_center(truth, X_BT);
      grey_px.push_back((grey_centroid(light, center) - center).norm());
      half_level_px.push_back((half_level_center(light, center) - center).norm());
    }
    CHECK(rms(grey_px) > 0.1);
    CHECK(rms(half_level_px) > 0.1);
  }
}

TEST_CASE("The glow turns with the tool") {
  Truth truth = test::evenly_lit_truth(1);
  truth.lamps[0].glow.gradient_tool << 0.2, 0.0;
  const auto shift_at = [&](double phi) -> Eigen::Vector2d {
    const Pose X_BT = test::tool_pose({0.0, 0.0}, phi);
    return grey_centroid(render(truth, X_BT), true_center(truth, X_BT)) - true_center(truth, X_BT);
  };
  // The camera looks down: a turn from x to y is a turn from u to -v.
  const Eigen::Vector2d turned = rotation2d(-kDegreesApart * kDegree) * shift_at(0.0);
  CHECK(shift_at(0.0).norm() > 0.1);
  CHECK((shift_at(kDegreesApart * kDegree) - turned).norm() < 0.02 * shift_at(0.0).norm());
}

TEST_CASE("The glow leans with the viewing angle, away from the camera's foot") {
  Truth truth = test::evenly_lit_truth(1);
  for (LampTruth& lamp : truth.lamps) lamp.glow.halo_view = 0.5;
  const auto lean_at = [&](double x) {
    const Pose X_BT = test::tool_pose({x, 0.0}, 0.0);
    return (grey_centroid(render(truth, X_BT), true_center(truth, X_BT)) - true_center(truth, X_BT))
        .x();
  };
  CHECK(lean_at(0.4) > 0.1);
  CHECK(lean_at(-0.4) < -0.1);
  CHECK(lean_at(0.4) > 1.5 * lean_at(0.2));
}

TEST_CASE("The rim's harmonics turn with the tool") {
  Truth truth = test::evenly_lit_truth(1);
  truth.lamps[0].rim = {{0.05, 0.5 * kPi, 2}};  // long along the tool's x axis
  const auto longer_along_u = [&](double phi) {
    const Pose X_BT = test::tool_pose({0.0, 0.0}, phi);
    const Light light = render(truth, X_BT);
    const Eigen::Vector2d center = true_center(truth, X_BT);
    const double rim_px = 0.5 * truth.lamps[0].diameter_m * 6400.0 / 1.53;
    return level_at(light, center + Eigen::Vector2d(rim_px, 0.0)) >
           level_at(light, center + Eigen::Vector2d(0.0, rim_px));
  };
  CHECK(longer_along_u(0.0));
  CHECK_FALSE(longer_along_u(0.5 * kPi));
}

TEST_CASE("No drawn lamp saturates the sensor anywhere in the working disc") {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Truth truth = draw_truth(seed);
    for (double angle = 0.0; angle < 2.0 * kPi; angle += 0.7) {
      const Light light = render(truth, test::tool_pose(0.54 * rotation2d(angle).col(0), angle));
      double brightest = 0.0;
      cv::minMaxLoc(light.levels, nullptr, &brightest);
      CHECK(brightest + truth.noise.background_level < 240.0);
    }
  }
}

}  // namespace planar
