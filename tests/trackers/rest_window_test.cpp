#include "planar_servo/machine/trackers/stream_tracker.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace planar {
namespace {

constexpr double kPeriod_s = 0.02;
constexpr double kSigma = 0.01 * kMillimetre;

TrackerSettings tracker_of(double sigma) {
  TrackerSettings tracker;
  tracker.sigma_m = sigma;
  return tracker;
}

/// A synthetic stream of a tracker that writes micrometres.
class RestBench {
 public:
  explicit RestBench(double sigma = kSigma, double stated = kSigma)
      : window(tracker_of(stated)), sigma_(sigma) {}

  RestWindow window;
  double now_s{100.0};

  void add(const Eigen::Vector3d& p_L) {
    Eigen::Vector3d read = p_L;
    for (double& coordinate : read)
      coordinate = 1e-6 * std::round(1e6 * (coordinate + sigma_ * normal_(random_)));
    now_s += kPeriod_s;
    window.add({"", std::nullopt, read, 1e-6}, now_s);
  }
  void rest(const Eigen::Vector3d& p_L, double duration_s) {
    for (double t_s = 0.0; t_s < duration_s; t_s += kPeriod_s) add(p_L);
  }
  /// Returns whether the stream was taken to be at rest while it moved at this speed.
  bool rests_at_speed(double metres_per_s) {
    bool at_rest = false;
    for (double t_s = 0.0; t_s < 5.0; t_s += kPeriod_s) {
      add(kPlace + Eigen::Vector3d(metres_per_s * t_s, 0.0, 0.0));
      at_rest = at_rest || window.at_rest().has_value();
    }
    return at_rest;
  }

  const Eigen::Vector3d kPlace{2.5, -1.0, 0.7};

 private:
  double sigma_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

}  // namespace

TEST_CASE("A reflector at rest is read as the mean of half a second, not earlier") {
  RestBench bench;
  bench.rest(bench.kPlace, 0.45);
  CHECK_FALSE(bench.window.at_rest());
  bench.rest(bench.kPlace, 0.2);
  const auto reading = bench.window.at_rest();
  REQUIRE(reading);
  CHECK((reading->p_L - bench.kPlace).norm() < kSigma);
  CHECK(reading->averaged == Approx(0.5 / kPeriod_s + 1.0).margin(1.1));
  CHECK(reading->t_s == Approx(bench.now_s - 0.25).margin(0.02));
}

TEST_CASE("Noise of the stated size is at rest in nearly every window") {
  RestBench bench;
  bench.rest(bench.kPlace, 0.6);
  int restless = 0;
  for (int i = 0; i < 2000; ++i) {
    bench.add(bench.kPlace);
    if (!bench.window.at_rest()) ++restless;
  }
  CHECK(restless == 0);
}

TEST_CASE("A reflector that moves is not at rest, slow as it may be") {
  for (const double speed_mm_s : {0.2, 1.0, 100.0}) {
    CAPTURE(speed_mm_s);
    CHECK_FALSE(RestBench().rests_at_speed(speed_mm_s * kMillimetre));
  }
}

TEST_CASE("Nothing of the place before remains in a reading") {
  RestBench bench;
  bench.rest(bench.kPlace, 1.0);
  const Eigen::Vector3d next = bench.kPlace + Eigen::Vector3d(0.2, 0.0, 0.0);
  bench.add(next);
  CHECK_FALSE(bench.window.at_rest());
  CHECK(bench.window.scatter_text().find("at rest at most by 0.0150 mm") != std::string::npos);
  while (!bench.window.at_rest()) bench.add(next);
  CHECK((bench.window.at_rest()->p_L - next).norm() < kSigma);
}

TEST_CASE("Readings that are the same to the last digit come from a frozen tracker") {
  RestBench bench(0.0);
  bench.rest(bench.kPlace, 0.6);
  CHECK(bench.window.is_frozen());
  RestBench noisy;
  noisy.rest(noisy.kPlace, 0.6);
  CHECK_FALSE(noisy.window.is_frozen());
  RestBench coarse(0.0, 0.1e-6);  // the last digit is coarser than the noise
  coarse.rest(coarse.kPlace, 0.6);
  CHECK_FALSE(coarse.window.is_frozen());
  CHECK(coarse.window.at_rest());
}

TEST_CASE("Zeros are no reading, however they are written") {
  RestWindow window(tracker_of(kSigma));
  for (int i = 0; i < 5; ++i) window.add({"", std::nullopt, {0.0, 0.0, 0.0}, 1e-3}, 10.0 + i);
  CHECK(window.is_frozen());
}

TEST_CASE("A slow tracker's reading takes five of its readings, and its clock's time") {
  RestWindow window(tracker_of(kSigma));
  for (int i = 0; i < 5; ++i) {
    CHECK_FALSE(window.at_rest());
    window.add({"", 1000.0 + i, {1.0, 1e-6 * i, 0.0}, 1e-6}, 10.0 + i);
  }
  REQUIRE(window.at_rest());
  CHECK(window.at_rest()->t_s == 1002.0);
}

}  // namespace planar
