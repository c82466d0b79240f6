#include "planar_servo/virtual_cell/virtual_cell.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "planar_servo/virtual_cell/virtual_drive.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr int kReadings = 4000;

struct TrackerBench {
  explicit TrackerBench(const Truth& truth,
                        const VirtualHardware& hardware = test::sample_hardware())
      : arm(truth, hardware, clock), tracker(truth, hardware, arm, clock) {}
  VirtualClock clock;
  VirtualArm arm;
  VirtualTracker tracker;
};

Truth noiseless(std::uint32_t seed) {
  Truth truth = draw_truth(seed);
  truth.tracker.sigma_m = 0.0;
  return truth;
}

}  // namespace

TEST_CASE("Readings of a resting tool scatter by the stated sigma on every axis") {
  const Truth truth = draw_truth(1);
  TrackerBench bench(truth);
  TrackerBench quiet(noiseless(1));
  const Eigen::Vector3d middle = quiet.tracker.measure_tool("").reading.p_L;
  Eigen::Array3d sum(0.0, 0.0, 0.0), squares(0.0, 0.0, 0.0);
  for (int i = 0; i < kReadings; ++i) {
    const Eigen::Array3d deviation = bench.tracker.measure_tool("").reading.p_L - middle;
    sum += deviation;
    squares += deviation.square();
  }
  const double sigma = truth.tracker.sigma_m;
  CHECK(sigma == Approx(1e-5));
  CHECK((sum.abs() / kReadings).maxCoeff() < 5.0 * sigma / std::sqrt(kReadings));
  const Eigen::Array3d measured = (squares / kReadings).sqrt();
  CHECK((measured / sigma - 1.0).abs().maxCoeff() < 5.0 / std::sqrt(2.0 * kReadings));
}

TEST_CASE("The reflector is seen where arm, tool offset and tracker pose put it") {
  Truth truth = noiseless(2);
  truth.tracker.bias_m = 0.0;
  TrackerBench bench(truth);
  const Eigen::Vector3d expected = truth.tracker.X_LB * (bench.arm.X_BT() * truth.tool.reflector_m);
  CHECK((bench.tracker.measure_tool("").reading.p_L - expected).norm() == 0.0);
}

TEST_CASE("The bias varies over the field and stays below the stated length") {
  const Truth truth = noiseless(3);
  VirtualHardware hardware = test::sample_hardware();
  hardware.monuments_B.clear();
  for (int i = -5; i <= 5; ++i)
    for (int k = -5; k <= 5; ++k)
      hardware.monuments_B.push_back(
          {std::to_string(i) + "/" + std::to_string(k), {0.1 * i, 0.1 * k, 0.0}});
  TrackerBench bench(truth, hardware);
  double least = 1.0, greatest = 0.0;
  for (const auto& [id, p_B] : hardware.monuments_B) {
    const double bias =
        (bench.tracker.measure_monument(id).reading.p_L - truth.tracker.X_LB * p_B).norm();
    least = std::min(least, bias);
    greatest = std::max(greatest, bias);
  }
  CHECK(truth.tracker.bias_m <= 3e-6);
  CHECK(greatest <= truth.tracker.bias_m * 1.000001);
  CHECK(greatest > 0.5 * truth.tracker.bias_m);
  CHECK(least < 0.7 * greatest);
}

TEST_CASE(
    "Few readings of the tool are off, none of a monument, and the others stay as they were") {
  Truth truth = draw_truth(4);
  truth.outliers = OutlierTruth{0.02, 0.0002, 0.003};
  TrackerBench bench(truth), plain(draw_truth(4));
  const Eigen::Vector3d missed = bench.arm.X_BT().translation() - plain.arm.X_BT().translation();
  REQUIRE(missed.norm() == 0.0);
  int off = 0;
  for (int i = 0; i < kReadings; ++i) {
    const double length =
        (bench.tracker.measure_tool("").reading.p_L - plain.tracker.measure_tool("").reading.p_L)
            .norm();
    if (length == 0.0) continue;
    ++off;
    CHECK(length > 0.0002 * 0.999);
    CHECK(length < 0.003 * 1.001);
  }
  const double expected = 0.02 * kReadings;
  CHECK(std::abs(off - expected) < 5.0 * std::sqrt(expected));
  for (int i = 0; i < kReadings; ++i)
    REQUIRE(bench.tracker.measure_monument("datum1").reading.p_L ==
            plain.tracker.measure_monument("datum1").reading.p_L);
}

TEST_CASE("Few places get the readings of an earlier one, whatever is read there") {
  Truth truth = noiseless(5);
  truth.tracker.mispaired_share = 0.02;
  TrackerBench bench(truth), plain(noiseless(5));
  for (TrackerBench* each : {&bench, &plain})
    for (int joint = 0; joint < 3; ++joint) each->arm.drive(joint).energize();
  std::vector<Eigen::Vector3d> earlier;
  int mixed_up = 0;
  for (int place = 0; place < kReadings; ++place) {
    const Eigen::Vector3i target = place * Eigen::Vector3i(3, 2, 1);
    for (TrackerBench* each : {&bench, &plain})
      for (int joint = 0; joint < 3; ++joint) each->arm.drive(joint).set_target(target[joint]);
    for (TrackerBench* each : {&bench, &plain}) each->clock.sleep_for_s(1.0);
    const std::string id = std::to_string(place);
    const Eigen::Vector3d p_L = bench.tracker.measure_tool(id).reading.p_L;
    REQUIRE(bench.tracker.measure_tool(id).reading.p_L == p_L);
    const Eigen::Vector3d here = plain.tracker.measure_tool(id).reading.p_L;
    if (p_L != here) {
      ++mixed_up;
      CHECK(std::find(earlier.begin(), earlier.end(), p_L) != earlier.end());
    }
    earlier.push_back(here);
  }
  const double expected = 0.02 * kReadings;
  CHECK(std::abs(mixed_up - expected) < 5.0 * std::sqrt(expected));
}

TEST_CASE("Errors of the tracker's angles move a reading across its beam, by its range") {
  Truth truth = noiseless(6);
  truth.tracker.azimuth_errors = {{2e-6, 0.3, 1}, {1.5e-6, 0.8, 2}};
  truth.tracker.elevation_errors = {{2e-6, 1.2, 1}};
  TrackerBench bench(truth), plain(noiseless(6));
  const Eigen::Vector3d read = bench.tracker.measure_tool("").reading.p_L;
  const Eigen::Vector3d p_L = plain.tracker.measure_tool("").reading.p_L;
  const double azimuth = std::atan2(p_L.y(), p_L.x());
  const double elevation = std::asin(p_L.z() / p_L.norm());
  const double off_azimuth =
      2e-6 * std::sin(azimuth + 0.3) + 1.5e-6 * std::sin(2.0 * azimuth + 0.8);
  const double off_elevation = 2e-6 * std::sin(elevation + 1.2);
  const Eigen::Vector3d moved = read - p_L;
  constexpr double kSecondOrder_m = 1e-10;
  CHECK(std::abs(moved.dot(p_L.normalized())) < kSecondOrder_m);
  const double across = moved.dot(Eigen::Vector3d(-std::sin(azimuth), std::cos(azimuth), 0.0));
  CHECK(std::abs(across - off_azimuth * p_L.head<2>().norm()) < kSecondOrder_m);
  CHECK(std::abs(moved.z() - off_elevation * p_L.head<2>().norm()) < kSecondOrder_m);
}

TEST_CASE("A tracker's station drifts by the hour, and settles half of its way in the half time") {
  Truth truth = noiseless(6);
  StationDriftTruth drift;
  drift.velocity_m_s << 2e-6 / 3600.0, 0.0, 0.0;
  drift.settling_m << 0.0, 4e-6, 0.0;
  drift.half_time_s = 1800.0;
  truth.tracker.drift = drift;
  TrackerBench bench(truth), plain(noiseless(6));
  const Eigen::Vector3d p_L = plain.tracker.measure_monument("datum1").reading.p_L;
  constexpr double kRoundOff = 1e-14;
  CHECK((bench.tracker.measure_monument("datum1").reading.p_L - p_L).norm() < kRoundOff);
  bench.clock.sleep_for_s(1800.0);
  const Eigen::Vector3d moved = bench.tracker.measure_monument("datum1").reading.p_L - p_L;
  CHECK((moved - Eigen::Vector3d(1e-6, 2e-6, 0.0)).norm() < kRoundOff);
}

TEST_CASE("Readings carry the clock's time and unknown monuments are refused") {
  TrackerBench bench(draw_truth(1));
  bench.clock.sleep_for_s(2.5);
  CHECK(bench.tracker.measure_tool("").reading.t_s == 2.5);
  CHECK(bench.tracker.measure_monument("datum1").status == TrackerStatus::kOk);
  CHECK_THROWS_AS(bench.tracker.measure_monument("datum9"), std::invalid_argument);
}

}  // namespace planar
