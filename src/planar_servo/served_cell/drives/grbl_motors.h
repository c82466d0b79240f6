#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/emulation/emulated_grbl.h"
#include "planar_servo/served_cell/drives/motor_trail.h"
#include "planar_servo/served_cell/live_cell.h"

namespace planar {

/// Pulses to which a served Grbl board says "a millimetre".
constexpr double kServedPulsesPerMm = 250.0;

/// Returns the speed that a motor's Grbl board is set to: the motor's own, but no more than what
/// lets the board rest within 0.15 s (see doc/drives.md), in steps of 0.001 deg/s.
double served_speed_deg_s(const MotorDrive& motor);

/// Puts the motors of a virtual cell behind an emulated Grbl board, joints 1 to 3 on its axes X to
/// Z. The board makes pulses; gears, directions and coupling are those of the truth. Its home
/// switches stand where the arm stands at first, at the cell's home.
class GrblMotors {
 public:
  /// `port` is the link to the board's serial port, as PtyPort has it. `live` must outlive this
  /// object.
  GrblMotors(const CellSettings& cell, const std::filesystem::path& port, LiveCell& live);
  ~GrblMotors();
  GrblMotors(const GrblMotors&) = delete;
  GrblMotors& operator=(const GrblMotors&) = delete;

 private:
  LiveCell& live_;
  MotorTrail trail_;
  EmulatedGrbl board_;
};

}  // namespace planar
