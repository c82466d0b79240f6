#pragma once

#include <Eigen/Core>
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/repeater.h"
#include "planar_servo/emulation/emulated_grbl.h"
#include "planar_servo/emulation/firmware_process.h"
#include "planar_servo/emulation/pty_port.h"

namespace planar {

/// Real firmware, run by its simulator, as a board on a serial port. What its motors have turned is
/// what it counts: its status reports say it, and while the program at the port does not ask for
/// them, the board does. (What the simulators print of steps ends some 50 ms before each motion.)
class FirmwareBoard {
 public:
  /// `options` are further ones of the simulator. The settings are stored first. `port` is the name
  /// of the serial port, as PtyPort has it. Throws like FirmwareProcess and PtyPort.
  FirmwareBoard(const std::filesystem::path& simulator, const std::vector<std::string>& options,
                const EmulatedGrbl::Settings& settings, const std::filesystem::path& port,
                EmulatedGrbl::OnPosition on_position = {});

  std::string port() const { return port_.name(); }
  /// Returns what the firmware says of itself, such as "Grbl 1.1h ['$' for help]".
  const std::string& banner() const { return firmware_.banner(); }
  /// Returns whether the motors rest, by the last report.
  bool rests() const { return rests_; }
  /// Throws WorkError when the firmware has ended.
  void require_well() const { relay_->require_well(); }

 protected:
  /// Lets the firmware end, and returns the folder in which it ran.
  const std::filesystem::path& end();

 private:
  void carry();
  void carry_to_firmware();
  void carry_to_program();
  void note(const std::string& report);

  SteadyClock clock_;
  FirmwareProcess firmware_;
  PtyPort port_;
  Eigen::Vector3d pulses_per_mm_, pulses_per_s_;
  EmulatedGrbl::OnPosition on_position_;
  EmulatedGrbl::Pulses shafts_{0, 0, 0};
  std::string heard_;
  bool asked_{false};  ///< by the program, which has no answer yet
  double last_question_s_{0.0}, placed_s_;
  std::atomic<bool> rests_{true};
  std::optional<Repeater> relay_;
};

}  // namespace planar
