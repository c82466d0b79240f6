#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/loop/servo/servo_result.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"

namespace planar::test {

/// A machine that differs from its data sheet: mock drives, gears with play, and an arm whose
/// kinematics are written here once more, without the project's own.
class SimulatedCell {
 public:
  /// Says what the machine really is.
  struct Truth {
    double link1_m{0.3011};
    double link2_m{0.2992};
    double zero1_rad{1.5e-3};
    double zero2_rad{-2.0e-3};
    double zero3_rad{5.0e-3};
    double sense{1.0};
    bool relative{true};                      ///< motor 2 rides on link 1
    Eigen::Vector3d pulses_per_rad{1, 1, 1};  ///< signed
    double play_rad{0.0};                     ///< play of each motor, behind its gear
    double scatter_m{0.0};                    ///< of every stop, per axis
  };

  explicit SimulatedCell(const Truth& truth) : truth_(truth) {}

  ManualClock& clock() { return clock_; }
  double now_s() const { return clock_.now_s(); }
  MockPulseDrive& drive(int i) { return drives_[i]; }
  DriveGroup& drives() { return group_; }

  /// Returns the number of targets sent to all drives.
  std::size_t targets_sent() const {
    return drives_[0].targets.size() + drives_[1].targets.size() + drives_[2].targets.size();
  }

  /// Returns where the end point really is.
  TipPose true_tip() const {
    const double m1 = output_rad(0);
    const double m2 = output_rad(1);
    const double a = m1 + truth_.zero1_rad;
    const double b = (truth_.relative ? m1 + m2 : m2) + truth_.zero2_rad;
    const double c = b - truth_.zero2_rad + output_rad(2) + truth_.zero3_rad;
    const Eigen::Vector2d p(
        truth_.link1_m * std::cos(a) + truth_.link2_m * std::cos(b),
        truth_.sense * (truth_.link1_m * std::sin(a) + truth_.link2_m * std::sin(b)));
    return {p + scatter(), truth_.sense * c};
  }

 private:
  /// Returns how far the arm has stopped beside its place; it stays there until the next move.
  Eigen::Vector2d scatter() const {
    std::seed_seq seed{targets_sent()};
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const double x = normal(random);
    return truth_.scatter_m * Eigen::Vector2d(x, normal(random));
  }

  /// Returns the gear's output, which follows its motor once the play is taken up.
  double output_rad(int i) const {
    double output = 0.0;
    for (const std::int32_t target : drives_[i].targets) {
      const double motor = target / truth_.pulses_per_rad[i];
      output = std::clamp(output, motor - truth_.play_rad / 2.0, motor + truth_.play_rad / 2.0);
    }
    return output;
  }

  Truth truth_;
  ManualClock clock_;
  std::array<MockPulseDrive, 3> drives_{MockPulseDrive(clock_), MockPulseDrive(clock_),
                                        MockPulseDrive(clock_)};
  SeparateDrives group_{{&drives_[0], &drives_[1], &drives_[2]}};
};

/// Sees the simulated cell's end point as it is, or with one of these faults.
class SimulatedSensor final : public TipSensor {
 public:
  explicit SimulatedSensor(const SimulatedCell& cell) : cell_(cell) {}

  std::optional<int> lamp_lost_from;  ///< number of the first measurement that sees no lamp
  std::optional<Eigen::Vector2d> mirrored_about;  ///< shows every error with the wrong sign
  double frame_noise_m{1e-7};
  Eigen::Vector2d offset_m{0.0, 0.0};
  bool inside_map{true};
  int measurements{0};
  std::optional<double> blind_from_s;  ///< the sensor is at fault from this time on

  std::optional<std::string> fault() const override {
    if (!blind_from_s || cell_.now_s() < *blind_from_s) return std::nullopt;
    return "the camera is blind";
  }

  TipMeasurement measure(const TipPose& /*expected*/, int frames) override {
    TipMeasurement measurement;
    if (lamp_lost_from && measurements >= *lamp_lost_from)
      measurement = failed_look(TipStatus::kNoLamps, "one_lamp", measurement.t_s);
    ++measurements;
    measurement.t_s = cell_.now_s();
    measurement.frames = frames;
    measurement.tip = cell_.true_tip();
    measurement.tip.p += offset_m;
    if (mirrored_about) measurement.tip.p = 2.0 * *mirrored_about - measurement.tip.p;
    measurement.noise_m = frame_noise_m / std::sqrt(frames);
    measurement.inside_map = inside_map;
    return measurement;
  }

 private:
  const SimulatedCell& cell_;
};

}  // namespace planar::test
