#include "planar_servo/virtual_cell/virtual_lens.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/core.hpp>

#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kNewton = 1e-13;         // where Newton's iteration stops, with some slack
constexpr double kWorkingRadiusM = 0.54;  // of the paper's field

}  // namespace

TEST_CASE("VirtualLens's distortion undoes its inverse polynomial over the whole field") {
  const VirtualLens lens(draw_truth(3).camera);
  for (double x = -0.42; x <= 0.42; x += 0.06)
    for (double y = -0.42; y <= 0.42; y += 0.06) {
      const auto distorted = lens.distorted_from_ideal({x, y});
      REQUIRE(distorted);
      CHECK((lens.ideal_from_distorted(*distorted) - Eigen::Vector2d(x, y)).norm() < kNewton);
    }
}

TEST_CASE("VirtualLens takes a distorted point to the closed form of its polynomial") {
  CameraTruth camera;
  camera.radial = {0.1, -0.2, 0.3};
  camera.decentring = {0.001, 0.002};
  const Eigen::Vector2d ideal = VirtualLens(camera).ideal_from_distorted({0.3, 0.4});
  const double scale = 1.0 + 0.25 * 0.1 - 0.0625 * 0.2 + 0.015625 * 0.3;
  CHECK(ideal.x() == Approx(0.3 * scale + 0.002 * 0.12 * 1.0 + 0.002 * (0.25 + 0.18)));
  CHECK(ideal.y() == Approx(0.4 * scale + 0.001 * (0.25 + 0.32) + 0.004 * 0.12));
}

TEST_CASE("A warming camera shifts, turns and grows its image towards an end, besides its drift") {
  CameraTruth camera = draw_truth(4).camera;
  camera.drift_px_per_h = {0.3, -0.2};
  const Eigen::Vector3d p_B(0.3, -0.4, 0.0);
  const Eigen::Vector2d cold = *VirtualLens(camera).project(p_B, 0.0);
  camera.warming = WarmingTruth{{0.5, -0.25}, 1e-4, 5e-5, 5400.0};
  const VirtualLens lens(camera);
  CHECK(*lens.project(p_B, 0.0) == cold);
  for (const double t_s : {600.0, 5400.0, 8.0 * 3600.0}) {
    const double way = 1.0 - std::exp(-t_s / 5400.0);
    const Eigen::Vector2d drifted = cold + camera.drift_px_per_h * t_s / 3600.0;
    const Eigen::Vector2d from_center = drifted - camera.center_px;
    const Eigen::Vector2d across(-from_center.y(), from_center.x());
    const Eigen::Vector2d expected = drifted + way * Eigen::Vector2d(0.5, -0.25) +
                                     5e-5 * way * from_center + 1e-4 * way * across;
    // What a rotation of 1e-4 rad differs from its linearisation, 2000 px from the middle.
    CHECK((*lens.project(p_B, t_s) - expected).norm() < 5e-5);
  }
}

TEST_CASE("VirtualLens projects nothing from behind or beyond its reach") {
  CameraTruth camera;
  camera.radial = {-1.0, 0.0, 0.0};  // folds over at r = 1 / sqrt(3)
  const VirtualLens lens(camera);
  CHECK(lens.project({0.1, 0.1, 1.0}, 0.0));
  CHECK_FALSE(lens.project({0.1, 0.1, -1.0}, 0.0));
  CHECK_FALSE(lens.project({2.0, 0.0, 1.0}, 0.0));
}

TEST_CASE("Pinhole, principal point, bump and drift add up in pixels") {
  CameraTruth camera;
  camera.focal_px << 1000.0, 1010.0;
  camera.center_px << 500.0, 400.0;
  camera.warp = {{{600.0, 400.0}, 50.0, {2.0, -1.0}}};
  camera.drift_px_per_h << 0.5, 1.0;
  const auto uv = VirtualLens(camera).project({0.2, 0.0, 2.0}, 1800.0);
  REQUIRE(uv);
  CHECK(uv->x() == Approx(600.0 + 2.0 + 0.25));
  CHECK(uv->y() == Approx(400.0 - 1.0 + 0.5));
}

TEST_CASE("The warp of a drawn cell is at least 0.3 px rms over the working disc") {
  for (std::uint32_t seed = 1; seed <= 10; ++seed)
    CHECK(warp_rms_px(draw_truth(seed).camera, kWorkingRadiusM) >= 0.3);
}

TEST_CASE("No plumb-bob lens with free scales explains a drawn lens to 0.1 px") {
  // Pixels are linear in (c, f, skew, f k1, f k2, f k3, f p1, f p2) of the ideal point.
  const Truth truth = draw_truth(5);
  const VirtualLens lens(truth.camera);
  cv::Mat1d design(0, 9), pixels(0, 1);
  for (double x = -kWorkingRadiusM; x <= kWorkingRadiusM; x += 0.03)
    for (double y = -kWorkingRadiusM; y <= kWorkingRadiusM; y += 0.03) {
      if (std::hypot(x, y) > kWorkingRadiusM) continue;
      const Eigen::Vector3d p_C = truth.camera.X_CB * Eigen::Vector3d(x, y, 0.0);
      const double a = p_C.x() / p_C.z(), b = p_C.y() / p_C.z(), s = a * a + b * b;
      design.push_back(cv::Mat1d((cv::Mat1d(1, 9) << 1, a, b, a * s, a * s * s, a * s * s * s,
                                  2 * a * b, s + 2 * a * a, b * s)));
      pixels.push_back(cv::Mat1d(1, 1, lens.project({x, y, 0.0}, 0.0)->x()));
    }
  cv::Mat1d fit;
  cv::solve(design, pixels, fit, cv::DECOMP_SVD);
  const cv::Mat1d residual = cv::Mat1d(pixels - design * fit);
  CHECK(cv::norm(residual) / std::sqrt(residual.rows) > 0.1);
}

}  // namespace planar
