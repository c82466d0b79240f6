#pragma once

#include <sys/types.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/emulation/pty_port.h"
#include "support/temporary_folder.h"

namespace planar::test {

/// Real firmware of a motion board, built for this machine, on a serial port.
class FirmwareProcess {
 public:
  /// Starts the simulator of Grbl or of grblHAL. `commands` are stored first, such as "$1=255".
  FirmwareProcess(const std::filesystem::path& simulator, const std::vector<std::string>& commands);
  ~FirmwareProcess();
  FirmwareProcess(const FirmwareProcess&) = delete;
  FirmwareProcess& operator=(const FirmwareProcess&) = delete;

  std::string port() const { return port_.name(); }
  void unplug() { port_.unplug(); }
  /// Ends it and returns the steps that its stepper interrupt has made, axes X to Z.
  std::array<int, 3> end();

 private:
  void start(const std::filesystem::path& simulator);
  void store(const std::vector<std::string>& commands);

  /// That of grblHAL takes a byte per pass of its main loop, and passes only when it does not wait
  /// for real time.
  bool in_real_time_;
  TemporaryFolder folder_;
  PtyPort port_{folder_ / "port"};
  pid_t process_{-1};
};

}  // namespace planar::test
