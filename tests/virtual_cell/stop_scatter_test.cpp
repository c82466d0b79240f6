#include "planar_servo/virtual_cell/virtual_arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "planar_servo/virtual_cell/virtual_cell.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr int kStops = 4000;
constexpr double kSigma_m = 20.0 * kMicrometre;
constexpr double kMargin_rad = 0.2 * kDegree;  // of an approach from one side

ScatterTruth some_scatter() {
  ScatterTruth scatter;
  scatter.sigma_m = kSigma_m;
  scatter.short_move_factor = 0.5;
  scatter.negative_factor = 1.3;
  return scatter;
}

/// Two cells that take the same moves, of which one scatters.
class ScatterBench {
 public:
  explicit ScatterBench(const Truth& plain, double sigma_m = kSigma_m)
      : plain_(plain, test::sample_hardware()),
        scattering_(with_scatter(plain, sigma_m), test::sample_hardware()) {
    for (VirtualCell* cell : {&plain_, &scattering_})
      for (int joint = 0; joint < 3; ++joint) cell->drive(joint).energize();
  }

  /// Sends the motors to these angles and returns the scatter there.
  Eigen::Vector2d direct(const Eigen::Vector3d& motors_rad, double rest_s = 0.3) {
    for (VirtualCell* cell : {&plain_, &scattering_}) send(*cell, motors_rad, rest_s);
    return scattering_.true_tip().p - plain_.true_tip().p;
  }
  /// As the servo arrives: first short of the place, where it hardly rests.
  Eigen::Vector2d one_sided(const Eigen::Vector3d& motors_rad) {
    direct(motors_rad - Eigen::Vector3d::Constant(kMargin_rad), 0.0);
    return direct(motors_rad);
  }
  VirtualCell& plain() { return plain_; }
  VirtualCell& scattering() { return scattering_; }

 private:
  static Truth with_scatter(Truth truth, double sigma_m) {
    truth.arm.scatter = some_scatter();
    truth.arm.scatter->sigma_m = sigma_m;
    return truth;
  }
  static void send(VirtualCell& cell, const Eigen::Vector3d& motors_rad, double rest_s) {
    const Eigen::Vector3d pulses = test::sample_hardware().pulses_per_rad();
    for (int joint = 0; joint < 3; ++joint)
      cell.drive(joint).set_target(
          static_cast<std::int32_t>(std::lround(pulses[joint] * motors_rad[joint])));
    const auto moves = [&] {
      return cell.drive(0).status().moving || cell.drive(1).status().moving ||
             cell.drive(2).status().moving;
    };
    while (moves()) cell.clock().sleep_for_s(5e-3);
    cell.clock().sleep_for_s(rest_s);
  }

  VirtualCell plain_, scattering_;
};

Truth silent_truth() {
  Truth truth = draw_truth(1);
  truth.tracker.sigma_m = 0.0;
  return truth;
}

/// Returns the middle of all bright pixels.
Eigen::Vector2d seen_px(VirtualCell& cell) {
  const cv::Moments light = cv::moments(cell.camera().next_frame().frame.image > 60, true);
  return {light.m10 / light.m00, light.m01 / light.m00};
}

Eigen::Array2d rms_per_axis(const std::vector<Eigen::Vector2d>& misses) {
  Eigen::Array2d squares(0.0, 0.0);
  for (const Eigen::Vector2d& miss : misses) squares += miss.array().square();
  return (squares / static_cast<double>(misses.size())).sqrt();
}

void check_rms(const std::vector<Eigen::Vector2d>& misses, double sigma_m) {
  // Five deviations of an rms, with the excess kurtosis of one stop in ten that misses twice as
  // far.
  const double tolerance = 5.0 * std::sqrt(3.5 / (4.0 * static_cast<double>(misses.size())));
  CHECK((rms_per_axis(misses) / sigma_m - 1.0).abs().maxCoeff() < tolerance);
}

}  // namespace

TEST_CASE("Stops scatter by the stated rms per axis, with some tails, after long moves") {
  StopScatter scatter(some_scatter(), 7);
  std::vector<Eigen::Vector2d> misses;
  double fourth = 0.0;
  for (int i = 0; i < kStops; ++i) {
    const Eigen::Vector2d p(0.1 * (i % 2), 0.3);
    misses.push_back(scatter.at_rest(p, false));
    fourth += std::pow(misses.back().x() / kSigma_m, 4) / kStops;
    scatter.leave(p, false, 1.0);
  }
  check_rms(misses, kSigma_m);
  CHECK(fourth > 3.5);
  CHECK(fourth < 6.0);
}

TEST_CASE("Stops scatter less after short moves and more where motor 1 arrives turning backwards") {
  StopScatter scatter(some_scatter(), 8);
  std::vector<Eigen::Vector2d> short_moves, backwards;
  for (int i = 0; i < kStops; ++i) {
    const Eigen::Vector2d far(0.1, 0.3), near(0.0, 0.3 + 0.0009 * (i % 2));
    short_moves.push_back(scatter.at_rest(near, false));
    scatter.leave(near, false, 0.1);
  }
  for (int i = 0; i < kStops; ++i) {
    const Eigen::Vector2d p(0.1 * (i % 2), 0.3);
    backwards.push_back(scatter.at_rest(p, true));
    scatter.leave(p, true, 0.1);
  }
  short_moves.erase(short_moves.begin());
  check_rms(short_moves, 0.5 * kSigma_m);
  backwards.erase(backwards.begin());
  check_rms(backwards, 1.3 * kSigma_m);
}

TEST_CASE("An approach from one side scatters by the way between two stops, not by its last bit") {
  ScatterBench bench(silent_truth());
  std::vector<Eigen::Vector2d> landings, corrections;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d far(0.2 + 0.3 * (i % 2), 1.0, 0.0);
    landings.push_back(bench.one_sided(far));
    corrections.push_back(bench.one_sided(far + Eigen::Vector3d(0.0, 0.001, 0.0)));
  }
  check_rms(landings, kSigma_m);
  check_rms(corrections, 0.5 * kSigma_m);
}

TEST_CASE("Camera, tracker and scorer see one scatter at a stop, which lasts as long as the stop") {
  ScatterBench bench(silent_truth(), 2.0 * kMillimetre);
  const Eigen::Vector2d miss = bench.direct({0.5, 1.0, 0.2});
  REQUIRE(miss.norm() > 0.2 * kMillimetre);
  const Eigen::Vector2d moved_px = seen_px(bench.scattering()) - seen_px(bench.plain());
  constexpr double kMetresPerPx = 0.24 * kMillimetre;  // in the middle of the field
  CHECK(moved_px.norm() * kMetresPerPx == Approx(miss.norm()).epsilon(0.05));
  const Truth truth = silent_truth();
  const Eigen::Vector3d seen = truth.tracker.X_LB.linear().transpose() *
                               (bench.scattering().tracker().measure_tool("").reading.p_L -
                                bench.plain().tracker().measure_tool("").reading.p_L);
  constexpr double kBias_m = 1e-7;  // what the tracker's bias changes over some millimetres
  CHECK((seen.head<2>() - miss).norm() < kBias_m);
  for (VirtualCell* cell : {&bench.plain(), &bench.scattering()}) cell->clock().sleep_for_s(60.0);
  CHECK(bench.scattering().true_tip().p - bench.plain().true_tip().p == miss);
  // Who commands the place where the arm stands moves nothing.
  CHECK(bench.direct({0.5, 1.0, 0.2}) == miss);
  CHECK(bench.direct({0.6, 1.0, 0.2}) != miss);
}

TEST_CASE("The same moves of the same seed scatter alike, however often somebody looks") {
  ScatterBench bench(silent_truth()), watched(silent_truth());
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d motors(0.1 * i, 1.0, 0.0);
    const Eigen::Vector2d miss = bench.one_sided(motors);
    watched.scattering().true_tip();
    REQUIRE(watched.one_sided(motors) == miss);
  }
}

}  // namespace planar
