#pragma once

#include <visp3/core/vpColVector.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"

namespace planar::test {

constexpr double kPulse_rad = 2.0 * kPi / 5e5;  ///< of the coarsest of the bench's drives

/// Returns the transmission of the bench, in which motor 2 turns backwards.
inline TransmissionSettings transmission_settings() {
  TransmissionSettings settings;
  settings.drives[0] = {10000.0, 100.0, 1, 1.0, 5.0};
  settings.drives[1] = {10000.0, 100.0, -1, 1.0, 5.0};
  settings.drives[2] = {10000.0, 50.0, 1, 2.0, 10.0};
  settings.limits_rad = {Eigen::Vector2d(-3.0, 3.0), Eigen::Vector2d(-2.8, 2.8),
                         Eigen::Vector2d(-6.2, 6.2)};
  return settings;
}

/// A robot on three mock drives. Where its tests say "drive 2" the index is 1.
struct Bench {
  explicit Bench(const TransmissionSettings& its_settings = transmission_settings())
      : settings(its_settings) {}

  TransmissionSettings settings;
  ManualClock clock;
  std::array<MockPulseDrive, 3> drives{MockPulseDrive(clock), MockPulseDrive(clock),
                                       MockPulseDrive(clock)};
  SeparateDrives group{{&drives[0], &drives[1], &drives[2]}};
  PlanarRobot robot{PlanarArm({{0.3, 0.25}, Rotation::kClockwise}), Transmission(settings), group,
                    clock};

  /// Returns true when no drive was sent a target.
  bool nothing_was_sent() const {
    return drives[0].targets.empty() && drives[1].targets.empty() && drives[2].targets.empty();
  }
};

/// A bench whose robot is switched on.
struct ReadyBench : Bench {
  explicit ReadyBench(const TransmissionSettings& its_settings = transmission_settings())
      : Bench(its_settings) {
    robot.energize();
  }
};

/// Returns the values as ViSP's column vector.
inline vpColVector column(std::initializer_list<double> values) {
  vpColVector result(static_cast<unsigned int>(values.size()));
  std::copy(values.begin(), values.end(), result.data);
  return result;
}

}  // namespace planar::test
