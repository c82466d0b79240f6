#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/emulation/pty_port.h"

namespace planar {

/// Real firmware of a motion board, built for this machine as a simulator: Grbl's or grblHAL's. It
/// runs on a serial line, in a folder of its own that goes with it.
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

  /// Returns what it says of itself, such as "Grbl 1.1h ['$' for help]".
  const std::string& banner() const { return banner_; }
  const std::filesystem::path& folder() const { return folder_.path; }

  /// Returns the line to be waited on.
  int descriptor() const { return line_.inner(); }
  /// Returns what has come on the line within the time.
  std::string read(double timeout_s) { return line_.read(timeout_s); }
  void write(std::string_view text) { line_.write(text); }

  /// Throws WorkError when the simulator has ended.
  void require_running();
  /// Lets it end by itself, which completes its files. Ends it when that takes too long.
  void end();

 private:
  struct Folder {
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::filesystem::path path;
  };

  /// Starts the simulator and waits for nothing.
  FirmwareProcess(const std::filesystem::path& simulator, const std::vector<std::string>& options);
  /// Returns the next line that begins so. Throws WorkError when none comes.
  std::string wait_for(std::string_view beginning, const std::string& purpose);

  std::filesystem::path simulator_;
  Folder folder_;
  PtyPort line_;
  pid_t process_{-1};
  std::string banner_, heard_;
};

}  // namespace planar
