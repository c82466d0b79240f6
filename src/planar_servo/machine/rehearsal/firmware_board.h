#pragma once

#include <sys/types.h>

#include <Eigen/Core>
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/machine/rehearsal/emulated_grbl.h"

namespace planar {

/// A folder for temporary files, which goes with all of them when this ends.
class PassingFolder {
 public:
  /// Its name begins with this. Throws WorkError when no folder can be made.
  explicit PassingFolder(const std::string& name);
  ~PassingFolder();
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Real firmware of a motion board, built for this machine as a simulator: Grbl's or grblHAL's. It
/// runs on a serial line, in a folder of its own that is removed with it.
class FirmwareProcess {
 public:
  /// Starts the simulator with further options, waits for its banner and lets it store commands,
  /// such as "$1=255". Throws InputError when `simulator` is no program, and WorkError when it is
  /// no firmware or does not obey.
  FirmwareProcess(const std::filesystem::path& simulator, const std::vector<std::string>& options,
                  const std::vector<std::string>& commands);
  /// Ends the simulator at once.
  ~FirmwareProcess();
  FirmwareProcess(const FirmwareProcess&) = delete;
  FirmwareProcess& operator=(const FirmwareProcess&) = delete;

  /// Returns its banner, such as "Grbl 1.1h ['$' for help]".
  const std::string& banner() const { return banner_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

  /// Returns the line on which it is spoken to.
  PtyPort& line() { return line_; }

  /// Throws WorkError when the simulator has ended.
  void require_running();
  /// Lets it end by itself, which completes its files; kills it when that takes too long.
  void end();

 private:
  /// Starts the simulator and waits for nothing.
  FirmwareProcess(const std::filesystem::path& simulator, const std::vector<std::string>& options);
  /// Returns the next line that begins so. Throws WorkError when none comes.
  std::string wait_for(std::string_view beginning, const std::string& purpose);

  std::filesystem::path simulator_;
  PassingFolder folder_{"planar-firmware"};
  PtyPort line_;
  pid_t process_{-1};
  std::string banner_, heard_;
};

/// Real firmware, run by its simulator, as a board on a serial port. Its motors have turned what
/// its status reports say; while the program at the port does not ask for them, the board does.
/// (What the simulators print of steps ends some 50 ms before each motion.)
class FirmwareBoard {
 public:
  /// `options` are further ones of the simulator. The settings are stored first. `port` is the name
  /// of the serial port, as PtyPort has it. Throws like FirmwareProcess and PtyPort.
  FirmwareBoard(const std::filesystem::path& simulator, const std::vector<std::string>& options,
                const EmulatedGrbl::Settings& settings, const std::filesystem::path& port,
                EmulatedGrbl::OnPosition on_position = {});

  std::string port() const { return port_.name(); }
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
