// umockdev-wrapper build/release/bin/host_tics N PROGRAM [ARGUMENT ...]
// Runs any program with N emulated Tics (serial numbers 00400001, ...) on its USB bus.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "support/emulated_tic.h"
#include "support/mock_usb.h"

int main(int argc, char** argv) {
  using namespace planar;
  if (argc < 3) {
    std::fputs("usage: host_tics N PROGRAM [ARGUMENT ...]\n", stderr);
    return 2;
  }
  SteadyClock clock;
  test::MockUsbBus bus;
  std::vector<std::unique_ptr<test::EmulatedTic>> tics;
  std::vector<std::unique_ptr<test::MockUsbDevice>> devices;
  for (int i = 0; i < std::atoi(argv[1]); ++i) {
    tics.push_back(std::make_unique<test::EmulatedTic>(clock));
    devices.push_back(std::make_unique<test::MockUsbDevice>(
        bus, test::EmulatedTic::description(std::to_string(400001 + i).insert(0, "00")),
        *tics.back()));
  }
  const pid_t child = fork();
  if (child == 0) {
    execvp(argv[2], argv + 2);
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}
