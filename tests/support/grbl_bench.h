#pragma once

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "planar_servo/hardware/drives/grbl_drives.h"
#include "support/eventually.h"
#include "support/faulty_grbl.h"
#include "support/temporary_folder.h"

namespace planar::test {

/// Returns a board whose axes make up to 4000 pulses/s and 40 000 pulses/s^2, for joints on axes X,
/// Z and Y.
inline GrblSettings grbl_settings_of(const std::string& port,
                                     HomeReference home = HomeReference::kTaught) {
  GrblSettings settings{port, 115200, {}};
  settings.axes = {GrblAxis{'X', 250.0, 4000.0, 40000.0, home},
                   GrblAxis{'Z', 250.0, 4000.0, 40000.0, home},
                   GrblAxis{'Y', 250.0, 4000.0, 40000.0, home}};
  return settings;
}

/// Returns the settings that such a board has stored.
inline std::map<int, double> stored_settings() {
  return {{1, 255},   {25, 3000}, {110, 960}, {111, 960},
          {112, 960}, {120, 160}, {121, 160}, {122, 160}};
}

/// Another program, `cat`, that has a port open.
class PortReader {
 public:
  explicit PortReader(const std::string& port) : process_(fork()) {
    if (process_ == 0) {
      execlp("cat", "cat", port.c_str(), nullptr);
      _exit(127);
    }
    eventually([&] { return is_cat() && has_open(std::filesystem::canonical(port)); });
  }
  ~PortReader() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  PortReader(const PortReader&) = delete;
  PortReader& operator=(const PortReader&) = delete;

  std::string name() const { return fmt::format("cat ({})", process_); }

 private:
  bool is_cat() const {
    std::string name;
    std::ifstream(fmt::format("/proc/{}/comm", process_)) >> name;
    return name == "cat";
  }
  bool has_open(const std::filesystem::path& file) const {
    std::error_code error;
    for (const auto& entry :
         std::filesystem::directory_iterator(fmt::format("/proc/{}/fd", process_), error))
      if (std::filesystem::read_symlink(entry, error) == file) return true;
    return false;
  }

  pid_t process_;
};

/// An emulated board on a serial port in a folder of its own.
struct GrblBench {
  explicit GrblBench(HomeReference home = HomeReference::kTaught)
      : board((folder / "port").string(), stored_settings()),
        settings(grbl_settings_of(board.port(), home)) {
    if (home == HomeReference::kTaught) return;
    board.set(22, 1);
    board.set(23, home == HomeReference::kReverseSwitch ? 7 : 0);
    board.place_switches(Eigen::Vector3d(-4.0, -8.0, -2.0));
  }

  TemporaryFolder folder;
  FaultyGrbl board;
  GrblSettings settings;
};

}  // namespace planar::test
