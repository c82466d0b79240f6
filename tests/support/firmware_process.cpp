#include "support/firmware_process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "planar_servo/drives/grbl/serial_line.h"

namespace planar::test {
namespace {

constexpr int kBaud = 115200;
constexpr double kPause_s = 0.1;
constexpr int kAttempts = 200;
constexpr const char* kEnd = "\x06";
/// So long between two rows of the steps that there are only those at the end of each block.
constexpr const char* kOnlyBlocks = "1e6";

}  // namespace

FirmwareProcess::FirmwareProcess(const std::filesystem::path& simulator,
                                 const std::vector<std::string>& commands)
    : in_real_time_(simulator.filename() == "grbl_sim") {
  start(simulator);
  try {
    store(commands);
  } catch (const std::exception&) {
    end();
    throw;
  }
}

FirmwareProcess::~FirmwareProcess() {
  end();
}

void FirmwareProcess::start(const std::filesystem::path& simulator) {
  const std::string steps = folder_ / "steps", folder = folder_.path();
  const std::string program = std::filesystem::absolute(simulator);
  process_ = fork();
  if (process_ != 0) return;
  dup2(port_.inner(), STDIN_FILENO);
  dup2(port_.inner(), STDOUT_FILENO);
  dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
  if (chdir(folder.c_str()) == 0)
    execl(program.c_str(), "sim", "-n", "-b", "/dev/null", "-s", steps.c_str(), "-r", kOnlyBlocks,
          "-t", in_real_time_ ? "1" : "0", nullptr);
  _exit(127);
}

void FirmwareProcess::store(const std::vector<std::string>& commands) {
  SerialLine line(port(), kBaud);
  const auto wait_for = [&](const std::string& beginning, const std::string& command) {
    for (int i = 0; i < kAttempts;) {
      const auto answer = line.read(kPause_s);
      if (answer && answer->rfind(beginning, 0) == 0) return;
      if (answer) continue;
      ++i;
      line.write("?");  // the simulator of Grbl reads on only when more comes
    }
    throw std::runtime_error("the firmware has not answered " + command);
  };
  wait_for("<", "a question");
  for (const std::string& command : commands) {
    line.write(command + "\n");
    wait_for("ok", command);
  }
}

std::array<int, 3> FirmwareProcess::end() {
  std::array<int, 3> steps{};
  if (process_ <= 0) return steps;
  { SerialLine(port(), kBaud).write(kEnd); }
  for (int i = 0; i < 500 && waitpid(process_, nullptr, WNOHANG) == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  if (waitpid(process_, nullptr, WNOHANG) == 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  process_ = -1;
  std::ifstream file(folder_ / "steps");
  for (std::string row; std::getline(file, row);) {
    std::array<int, 3> read{};
    if (std::sscanf(row.c_str(), "%*f %d, %d, %d", &read[0], &read[1], &read[2]) == 3) steps = read;
  }
  return steps;
}

}  // namespace planar::test
