#include "planar_servo/served_cell/drives/grbl_motors.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kLongestBraking_s = 0.15;
constexpr double kSpeedStep_deg_s = 1e-3;
constexpr double kHomingFeed_mm_min = 6000.0;
constexpr int kStepIdleDelay = 1, kHomingEnabled = 22, kHomingDirections = 23, kHomingFeed = 25,
              kPulsesPerMm = 100, kMaxRate = 110, kAcceleration = 120;

EmulatedGrbl::Settings board_settings(const TransmissionSettings& transmission) {
  EmulatedGrbl::Settings settings{{kStepIdleDelay, 255},
                                  {kHomingEnabled, 1},
                                  {kHomingDirections, 7},
                                  {kHomingFeed, kHomingFeed_mm_min}};
  const Eigen::Vector3d pulses_per_rad = Transmission(transmission).pulses_per_rad();
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& motor = transmission.drives[static_cast<std::size_t>(i)];
    const double mm_per_rad = std::abs(pulses_per_rad[i]) / kServedPulsesPerMm;
    settings[kPulsesPerMm + i] = kServedPulsesPerMm;
    settings[kMaxRate + i] = 60.0 * mm_per_rad * served_speed_deg_s(motor) * kDegree;
    settings[kAcceleration + i] = mm_per_rad * motor.max_acceleration_rad_s2;
  }
  return settings;
}

}  // namespace

double served_speed_deg_s(const MotorDrive& motor) {
  const double longest = kLongestBraking_s * motor.max_acceleration_rad_s2;
  const double speed_deg_s = std::min(motor.max_speed_rad_s, longest) / kDegree;
  // What a file rounds to the step above by its last digit is that step.
  return kSpeedStep_deg_s * std::floor(speed_deg_s / kSpeedStep_deg_s + 1e-6);
}

GrblMotors::GrblMotors(const CellSettings& cell, const std::filesystem::path& port, LiveCell& live)
    : live_(live),
      board_(port, board_settings(cell.transmission),
             [this](const EmulatedGrbl::Pulses& shafts) { trail_.add(shafts); }) {
  board_.place_switches(Eigen::Vector3d::Zero());
  const Pulses home = Transmission(cell.transmission).pulses_from_joints(cell.arm.home);
  live_.set_mover([this, home](VirtualCell& virtual_cell) {
    for (const MotorTrail::Pulses& shafts : trail_.take())
      for (int i = 0; i < 3; ++i) virtual_cell.turn_motor(i, home[i] + shafts[i]);
  });
}

GrblMotors::~GrblMotors() {
  live_.set_mover({});
}

}  // namespace planar
