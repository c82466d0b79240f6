#include "planar_servo/calibration/tracker_registration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Pose tracker_pose() {
  Pose X_BL = Pose::Identity();
  X_BL.linear() = rotation_from_vector({0.1, -0.2, 2.1});
  X_BL.translation() = Eigen::Vector3d(2.5, -1.0, 0.7);
  return X_BL;
}

std::vector<Monument> square_corner() {
  return {{"d1", {-0.45, -0.45, 0.0}}, {"d2", {0.45, 0.45, 0.0}}, {"d3", {-0.45, 0.45, 0.0}}};
}

std::vector<MonumentReading> readings_of(const std::vector<Monument>& monuments, int repeats,
                                         double noise) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, noise);
  std::vector<MonumentReading> readings;
  for (int k = 0; k < repeats; ++k) {
    for (const Monument& monument : monuments) {
      const Eigen::Vector3d error{normal(random), normal(random), normal(random)};
      readings.push_back({monument.id, tracker_pose().inverse() * monument.p_B + error});
    }
  }
  return readings;
}

}  // namespace

TEST_CASE("Monuments read repeatedly tie the tracker to the base, their noise averaged") {
  constexpr double kNoise = 0.010 * kMillimetre;
  constexpr int kRepeats = 25;
  const DatumRegistration datum =
      register_datum(square_corner(), readings_of(square_corner(), kRepeats, kNoise));
  const double kThreeSigma = 3.0 * kNoise / std::sqrt(kRepeats) * std::sqrt(3.0);
  for (const Eigen::Vector3d& p_B : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.4, -0.3, 0.1)}) {
    CHECK((datum.X_BL * (tracker_pose().inverse() * p_B) - p_B).norm() < kThreeSigma);
  }
  CHECK(datum.rms < kThreeSigma);
  REQUIRE(datum.residuals.size() == 3);
  CHECK(datum.residuals[1].id == "d2");
  CHECK(datum.residuals[1].readings == kRepeats);
}

TEST_CASE("A monument that moved shows in the residuals") {
  std::vector<Monument> monuments = square_corner();
  monuments.push_back({"d4", {0.45, -0.45, 0.0}});
  std::vector<MonumentReading> readings = readings_of(monuments, 1, 0.0);
  readings.back().p_L += Eigen::Vector3d(0.0, 0.0, 2.0 * kMillimetre);
  const DatumRegistration datum = register_datum(monuments, readings);
  CHECK(datum.rms > 0.3 * kMillimetre);
}

TEST_CASE("Exchanged monuments are refused") {
  std::vector<MonumentReading> readings = readings_of(square_corner(), 1, 0.0);
  std::swap(readings[0].id, readings[2].id);
  CHECK_THROWS_MATCHES(register_datum(square_corner(), readings), InputError,
                       Refused(Cause::kContradiction, "datum"));
}

TEST_CASE("Every fault of a datum is named") {
  std::vector<MonumentReading> readings = readings_of(square_corner(), 1, 0.0);
  readings.push_back({"dutam1", Eigen::Vector3d::Zero()});
  readings[0].p_L.x() = kNaN;
  CHECK_THROWS_MATCHES(register_datum(square_corner(), readings), InputError,
                       Refused(Cause::kInvalid, "'dutam1'"));
  CHECK_THROWS_MATCHES(register_datum(square_corner(), readings), InputError,
                       Refused(Cause::kInvalid, "'d1'"));
  std::vector<Monument> twice = square_corner();
  twice.push_back(twice[0]);
  CHECK_THROWS_MATCHES(register_datum(twice, {}), InputError, Refused(Cause::kExists, "'d1'"));
}

TEST_CASE("Two monuments, or three on one line, are no datum") {
  std::vector<MonumentReading> readings = readings_of(square_corner(), 1, 0.0);
  readings.pop_back();
  CHECK_THROWS_MATCHES(register_datum(square_corner(), readings), InputError,
                       Refused(Cause::kInsufficient, "2 of"));
  const std::vector<Monument> line{
      {"a", {0.0, 0.0, 0.0}}, {"b", {0.5, 0.0, 0.0}}, {"c", {1.0, 0.0, 0.0}}};
  CHECK_THROWS_MATCHES(register_datum(line, readings_of(line, 1, 0.0)), InputError,
                       Refused(Cause::kInsufficient, "rigid fit"));
}

}  // namespace planar
