#include "planar_servo/virtual_cell/virtual_arm.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/virtual_drive.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

constexpr double kRunout_m = 8.0 * kMicrometre;

Pose pose_at(const Truth& truth, const Eigen::Vector3d& home_rad) {
  VirtualHardware hardware = test::sample_hardware();
  hardware.home_rad = home_rad;
  VirtualClock clock;
  return VirtualArm(truth, hardware, clock).X_BT();
}

}  // namespace

TEST_CASE("An axis runs out once per turn by the stated size, and is not back after a turn") {
  Eigen::Vector2d once(0.0, 0.0);
  double greatest = 0.0;
  constexpr int kTurns = 100, kAngles = 36000;
  for (int i = 0; i < kAngles; ++i) {
    const double joint_rad = 2.0 * kPi * kTurns * i / kAngles;
    const Eigen::Vector2d p = runout_m(joint_rad, kRunout_m, 0.7);
    once += rotation2d(joint_rad).transpose() * p / kAngles;
    greatest = std::max(greatest, p.norm());
  }
  CHECK(once.norm() == Approx(kRunout_m).epsilon(0.1));
  CHECK((once - turning_runout_m(0.0, kRunout_m, 0.7)).norm() < 0.01 * kRunout_m);
  CHECK(greatest < 1.4 * kRunout_m + 1e-12);
  CHECK((runout_m(0.5 + 2.0 * kPi, kRunout_m, 0.7) - runout_m(0.5, kRunout_m, 0.7)).norm() >
        0.1 * kRunout_m);
}

TEST_CASE("The runout of each axis moves the tip in the frame of the link before it") {
  const Truth plain = draw_truth(1);
  const Eigen::Vector3d home(0.3, 1.2, -0.4);
  for (int joint = 0; joint < 3; ++joint) {
    Truth truth = plain;
    truth.arm.runout = AxisErrorTruth();
    truth.arm.runout->sizes[joint] = kRunout_m;
    truth.arm.runout->phases_rad[joint] = 0.7;
    const double before_rad = joint == 0 ? 0.0 : home[joint - 1];
    const Eigen::Vector2d moved =
        (pose_at(truth, home).translation() - pose_at(plain, home).translation()).head<2>();
    Eigen::Vector2d expected = runout_m(home[joint] - before_rad, kRunout_m, 0.7);
    // What turns with the tool is part of where the tip lies in it.
    if (joint == 2) expected -= turning_runout_m(home[joint] - before_rad, kRunout_m, 0.7);
    expected = rotation2d(before_rad) * expected;
    CHECK((moved - expected).norm() < 0.01 * kRunout_m);  // the joints' own errors are small
  }
}

TEST_CASE("An axis that wobbles leans by the stated angle, to a side that turns with its joint") {
  constexpr double kLean = 1.5e-5;
  const Eigen::Vector2d here = wobble_rad(0.4, kLean, 0.1);
  const Eigen::Vector2d across = wobble_rad(0.4 + kPi, kLean, 0.1);
  CHECK(here.norm() == Approx(kLean));
  CHECK(here.dot(across) < -0.5 * kLean * kLean);
  const Truth plain = draw_truth(1);
  Truth truth = plain;
  truth.arm.wobble = AxisErrorTruth();
  truth.arm.wobble->sizes[0] = kLean;
  const Eigen::Vector3d home(0.3, 1.2, -0.4);
  const double lifted_m =
      std::abs(pose_at(truth, home).translation().z() - pose_at(plain, home).translation().z());
  CHECK(lifted_m > 0.1 * kMicrometre);
  CHECK(lifted_m < 0.6 * kLean);
}

TEST_CASE("The tool's height waves by its amplitude over the plane, and its waves get shorter") {
  const HeightWaveTruth wave{60.0 * kMicrometre, {0.4, 0.1}};
  double least = 1.0, greatest = -1.0;
  std::vector<double> crossings_m;
  for (int i = 0; i <= 1000; ++i) {
    const double z = height_wave_m(wave, wave.center_m + Eigen::Vector2d(-0.001 * i, 0.0));
    const double next = height_wave_m(wave, wave.center_m + Eigen::Vector2d(-0.001 * (i + 1), 0.0));
    least = std::min(least, z);
    greatest = std::max(greatest, z);
    if (z * next < 0.0) crossings_m.push_back(0.001 * i);
  }
  CHECK(least == Approx(-60.0 * kMicrometre).epsilon(0.01));
  CHECK(greatest == Approx(60.0 * kMicrometre).epsilon(0.01));
  REQUIRE(crossings_m.size() > 4);
  const std::size_t last = crossings_m.size() - 1;
  CHECK(crossings_m[last] - crossings_m[last - 1] < 0.8 * (crossings_m[2] - crossings_m[1]));
}

TEST_CASE("An arm bends by its posture, never further than stated, and otherwise a turn later") {
  const BendingTruth bending{20.0 * kMicrometre, 0.3};
  double greatest = 0.0;
  for (double link1 = -kPi; link1 < kPi; link1 += 0.1)
    for (double elbow = 0.3; elbow < 2.9; elbow += 0.1)
      greatest = std::max(greatest, bending_m(bending, link1, link1 + elbow).norm());
  CHECK(greatest <= bending.largest_m);
  CHECK(greatest > 0.5 * bending.largest_m);
  CHECK(
      (bending_m(bending, 1.0 + 2.0 * kPi, 2.5 + 2.0 * kPi) - bending_m(bending, 1.0, 2.5)).norm() >
      0.1 * bending.largest_m);
}

TEST_CASE("A base moves to and fro once in a period, unevenly, as far as stated") {
  const BaseMotionTruth motion{10.0 * kMicrometre, 1080.0, 0.5};
  double least = 1.0, greatest = -1.0;
  int rising = 0;
  const auto along_m = [&](double time_s) {
    return (rotation2d(-0.5) * base_shift_m(motion, time_s)).x();
  };
  for (int s = 0; s < 1080; ++s) {
    least = std::min(least, along_m(s));
    greatest = std::max(greatest, along_m(s));
    rising += along_m(s + 1) > along_m(s) ? 1 : 0;
    REQUIRE((base_shift_m(motion, s + 1.0) - base_shift_m(motion, s)).norm() < 0.15 * kMicrometre);
  }
  CHECK(least == Approx(-motion.largest_m).epsilon(0.01));
  CHECK(greatest == Approx(motion.largest_m).epsilon(0.01));
  CHECK(rising == Approx(432).margin(2));
  CHECK((base_shift_m(motion, 1380.0) - base_shift_m(motion, 300.0)).norm() < 1e-12);
}

}  // namespace planar
