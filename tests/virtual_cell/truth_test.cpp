#include "planar_servo/virtual_cell/truth/truth.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/virtual_cell/virtual_arm.h"
#include "planar_servo/virtual_cell/virtual_drive.h"
#include "planar_servo/virtual_cell/virtual_lens.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

/// Where the arm of a truth stands when sent to p by the inverse kinematics of a 300 + 300 mm arm.
Eigen::Vector2d reached(const Truth& truth, const Eigen::Vector2d& p) {
  VirtualHardware hardware = test::sample_hardware();
  const double alpha = std::acos(p.norm() / 0.6);
  const double f = std::atan2(p.y(), p.x());
  hardware.home_rad << f - alpha, f + alpha, 0.0;
  VirtualClock clock;
  return VirtualArm(truth, hardware, clock).tip().p;
}

/// The last numbers drawn of a cell's parts, which change when any draw before them does.
struct LastDraws {
  std::uint32_t seed;
  double sag_mm, drift_px_per_h, reflector_mm, bias_wavelength_mm;
};

}  // namespace

TEST_CASE("A seed draws the cell of the paper's kind that it has always drawn") {
  const LastDraws kept[] = {
      {1, 1.0779094226274157, 0.013699508157527586, 19.94837626348284, 688.4363289756174},
      {7, 1.4566034465517144, 0.0013240315631040422, 20.136932740355174, 641.8540843589049},
      {99, 1.9930855309829316, -0.02449904401288617, 19.90638873157617, 611.6281250167201}};
  for (const LastDraws& draws : kept) {
    const Truth truth = draw_truth(draws.seed);
    constexpr double kLibrary = 1e-12;  // other libraries' sines and logarithms
    CHECK(truth.arm.sag_m_per_m2 / kMillimetre == Approx(draws.sag_mm).epsilon(kLibrary));
    CHECK(truth.camera.drift_px_per_h.x() == Approx(draws.drift_px_per_h).epsilon(kLibrary));
    CHECK(truth.tool.reflector_m.z() / kMillimetre == Approx(draws.reflector_mm).epsilon(kLibrary));
    CHECK(truth.tracker.bias_wavelength_m / kMillimetre ==
          Approx(draws.bias_wavelength_mm).epsilon(kLibrary));
    CHECK_FALSE(truth.arm.beam_sag.has_value());
    CHECK_FALSE(truth.arm.axis_leans_rad.has_value());
    CHECK_FALSE(truth.outliers.has_value());
    CHECK(truth.arm.reducers[0].eccentricity.size() == 2);
  }
}

TEST_CASE("A rough cell has the camera, lamps and tracker of the paper's kind and another arm") {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const Truth rough = draw_rough_truth(seed), paper = draw_truth(seed);
    CHECK(rough.camera.X_CB.isApprox(paper.camera.X_CB, 0.0));
    CHECK(rough.lamps[1].peak_level == paper.lamps[1].peak_level);
    CHECK(rough.tracker.bias_wavelength_m == paper.tracker.bias_wavelength_m);
    CHECK(rough.arm.link_lengths_m == paper.arm.link_lengths_m);
    CHECK(rough.arm.sag_m_per_m2 == 0.0);
    for (const ReducerTruth& reducer : rough.arm.reducers) {
      REQUIRE(reducer.eccentricity.size() == 3);
      CHECK(reducer.eccentricity[2].order == 3);
      CHECK(reducer.eccentricity[2].amplitude > 0.0019 * kDegree);
      CHECK(reducer.eccentricity[2].amplitude < 0.0041 * kDegree);
    }
    for (const Eigen::Vector2d& lean : *rough.arm.axis_leans_rad) {
      CHECK(lean.norm() > 0.0);
      CHECK(lean.norm() < 0.051 * kDegree);
    }
    CHECK(rough.outliers->share == 0.02);
  }
}

TEST_CASE("A drawn arm misses its targets by about 1 to 2 mm") {
  double mean_of_all = 0.0;
  constexpr int kSeeds = 20;
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const Truth truth = draw_truth(seed);
    double mean = 0.0;
    for (const double x : {-0.2, 0.2})
      for (const double y : {-0.2, 0.2})
        for (int i = 0; i < 25; ++i) {
          const Eigen::Vector2d p =
              Eigen::Vector2d(x, y) + 0.2 * rotation2d(2.0 * kPi * i / 25).col(0);
          mean += (reached(truth, p) - p).norm() / 100.0;
        }
    CHECK(mean > 0.4e-3);
    CHECK(mean < 3.0e-3);
    mean_of_all += mean / kSeeds;
  }
  CHECK(mean_of_all > 1.0e-3);
  CHECK(mean_of_all < 2.0e-3);
}

TEST_CASE("Every drawn camera sees the lamps on the whole working disc") {
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const VirtualLens lens(draw_truth(seed).camera);
    bool seen = true;
    for (double angle = 0.0; angle < 2.0 * kPi; angle += 0.1) {
      const Eigen::Vector2d p = 0.575 * rotation2d(angle).col(0);  // rim of the outermost lamp
      const auto uv = lens.project({p.x(), p.y(), 0.005}, 0.0);
      seen = seen && uv && uv->minCoeff() > 20.0 && uv->maxCoeff() < 5099.0;
    }
    CHECK(seen);
  }
}

TEST_CASE("Drawn cameras look down from about 1536 mm, tilted by 1 to 2 degrees") {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const CameraTruth camera = draw_truth(seed).camera;
    CHECK(camera.X_CB.inverse().translation().z() == Approx(1.536).margin(0.01));
    const double tilt = std::acos(-camera.X_CB.linear()(2, 2));
    CHECK(tilt > 0.99 * kDegree);
    CHECK(tilt < 2.01 * kDegree);
    CHECK(camera.focal_px.x() != camera.focal_px.y());
  }
}

}  // namespace planar
