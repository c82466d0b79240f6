#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <mutex>
#include <optional>
#include <vector>

#include "planar_servo/base/io/line_reader.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/rehearsal/emulated_grbl.h"
#include "planar_servo/machine/rehearsal/firmware_board.h"
#include "planar_servo/machine/rehearsal/live_cell.h"

namespace planar {

/// The pulses that a served Grbl board counts as a millimetre.
constexpr double kServedPulsesPerMm = 250.0;

/// What turns the motors of a served cell.
enum class ServedBoard {
  kEmulated,  ///< a Grbl board that has home switches where the arm stands at first
  kFirmware,  ///< a Grbl board run by real firmware, which has none
  kShafts,    ///< whoever writes lines of three counts into a pipe
};

/// Returns the speed that a motor's Grbl board is set to: the motor's own, but no more than what
/// lets the board rest within 0.15 s, or real firmware within 0.07 s (see doc/drives.md), in steps
/// of 0.001 deg/s.
double served_speed_deg_s(const MotorDrive& motor, ServedBoard board);

/// The way that motors have gone, to be followed later: no reversal of a motor is lost, and further
/// steps in the same direction take no memory. Safe to use from any thread.
class MotorTrail {
 public:
  using Pulses = Eigen::Vector3i;

  void add(const Pulses& pulses);
  /// Returns the places since the last call at which a motor turned back, and the last place.
  std::vector<Pulses> take();

 private:
  std::mutex mutex_;
  std::vector<Pulses> places_;
};

/// A pipe of this machine into which any program writes where the motors are: lines of three
/// counts. `at` before them says that the motors stand, and are counted so from now on.
class ShaftPipe {
 public:
  /// Makes the pipe in place of an earlier one. Throws InputError when that is impossible or a file
  /// is there.
  ShaftPipe(std::filesystem::path pipe, EmulatedGrbl::OnPosition on_position);
  ~ShaftPipe();
  ShaftPipe(const ShaftPipe&) = delete;
  ShaftPipe& operator=(const ShaftPipe&) = delete;

  void require_well() const { reader_->require_well(); }

 private:
  void read();

  std::filesystem::path pipe_;
  int descriptor_;
  EmulatedGrbl::Pulses here_{0, 0, 0}, zero_{0, 0, 0};  ///< zero_ is where the counts are 0
  EmulatedGrbl::OnPosition on_position_;
  std::optional<LineReader> lines_;
  std::optional<Repeater> reader_;
};

/// Puts the motors of a virtual cell, at its home at first, behind a Grbl board, joints 1 to 3 on
/// its axes X to Z, or lets them follow counts. Gears, directions and coupling are those of the
/// truth.
class ServedMotors {
 public:
  /// `port` is the link to the board's serial port, as PtyPort has it, or the pipe; `firmware` a
  /// simulator of Grbl 1.1. `live` must outlive this object. Throws like PtyPort, ShaftPipe and
  /// FirmwareBoard.
  ServedMotors(const CellSettings& cell, const std::filesystem::path& port, LiveCell& live,
               ServedBoard board = ServedBoard::kEmulated,
               const std::filesystem::path& firmware = {});
  ~ServedMotors() { live_.set_mover({}); }
  ServedMotors(const ServedMotors&) = delete;
  ServedMotors& operator=(const ServedMotors&) = delete;

  /// Turns the arm by hand to the marks of its motors, at the cell's home. Returns false when it
  /// moves, or is homed by switches.
  bool put_at_marks();
  /// Throws WorkError when the firmware has ended or a line is not three counts.
  void require_well() const;

 private:
  void follow(VirtualCell& virtual_cell);

  LiveCell& live_;
  MotorTrail trail_;
  MotorTrail::Pulses home_;               ///< as the truth counts
  MotorTrail::Pulses counted_{0, 0, 0};   ///< by the board where the arm stands
  MotorTrail::Pulses at_marks_{0, 0, 0};  ///< by the board at the marks
  std::optional<EmulatedGrbl> emulated_;
  std::optional<FirmwareBoard> firmware_;
  std::optional<ShaftPipe> shafts_;
};

}  // namespace planar
