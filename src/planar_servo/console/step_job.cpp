#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/console/arm_jobs.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/hardware/robot/planar_robot.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kLook_ms = 100;  // between two looks whether to stop

/// Starts a shell's command, which finds our programs first and prints to `output`.
pid_t start_shell(std::string command, int output) {
  const char* path = std::getenv("PATH");
  std::string ours =
      fmt::format("PATH={}:{}", fs::read_symlink("/proc/self/exe").parent_path().string(),
                  path == nullptr ? "" : path);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::array<char, 4> env{"env"}, shell{"sh"}, option{"-c"};
  std::array<char*, 6> words{env.data(),    ours.data(),    shell.data(),
                             option.data(), command.data(), nullptr};
  pid_t child = -1;
  const int fault = posix_spawn(&child, "/usr/bin/env", &files, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0) throw WorkError("no process can be started", Cause::kSystem);
  return child;
}

/// Runs such a command, tells each line that it prints, and returns its exit status. Once `stop`
/// answers true, the command is asked to end.
int run_shell(const std::string& command, const std::function<bool()>& stop,
              const std::function<void(std::string)>& tell) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw WorkError("no pipe can be made", Cause::kSystem);
  const AtEnd closed([&] { close(ends[0]); });
  pid_t child = -1;
  {
    const AtEnd closed_here([&] { close(ends[1]); });
    child = start_shell(command, ends[1]);
  }
  std::string text;
  bool stopped = false;
  for (std::array<char, 4096> read_now{};;) {
    if (!stopped && stop()) stopped = kill(-child, SIGINT) == 0;
    pollfd said{ends[0], POLLIN, 0};
    if (poll(&said, 1, kLook_ms) <= 0) continue;
    const ssize_t n = ::read(ends[0], read_now.data(), read_now.size());
    if (n <= 0) break;
    text.append(read_now.data(), static_cast<std::size_t>(n));
    for (std::size_t end = 0; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
      tell(text.substr(0, end));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_FAILURE;
}

/// Begins a job that runs a command. `finish` makes the words of a good end from its last line.
int begin_command(ConsoleJobs& jobs, const std::string& kind, const std::string& name,
                  const std::string& command, StopsKnown known,
                  const std::function<std::string(const std::string& said)>& finish) {
  const auto calculate = [=, &jobs](CellDevices& /*devices*/, const CellJobs::Stop& stop,
                                    const CellJobs::Begun& begun) -> CellJobs::Ending {
    begun(0, 0);
    std::string last;
    const int status = run_shell(command, stop, [&](std::string line) {
      jobs.board.tell_line("info", line);
      last = std::move(line);
    });
    if (stop()) throw StopRequested(name + " was stopped");
    if (status != 0) return {last, false};
    return {finish(last), true};
  };
  return jobs.places.begin(Doing::kCalculating, kind, name, known, calculate);
}

}  // namespace

int begin_step(ConsoleJobs& jobs, const std::string& board, StopsKnown known) {
  const auto step = next_step(jobs.cell.settings().file, board);
  if (!step) throw InputError("nothing is left to do", Cause::kMissing);
  if (!step->is_calculated)
    throw InputError({fmt::format("next is {}: {}", step->name, step->what),
                      "do it on this page, or by the command that is named"});
  return begin_command(jobs, "step", step->name, step->command, known,
                       [&jobs, name = step->name](const std::string& /*said*/) {
                         jobs.changed();
                         return name + " is done";
                       });
}

int begin_experiment(ConsoleJobs& jobs, const std::string& name, StopsKnown known) {
  const CellSettings& cell = jobs.cell.settings();
  if (!cell.truth)
    throw InputError({"an experiment moves a real cell by itself, whose devices this console holds",
                      "end the console, then use planar-experiment", cell.file});
  const std::string command =
      fmt::format("planar-experiment --cell {} --out {}", shell_word(cell.file),
                  shell_word(jobs.places.folder(name)));
  return begin_command(jobs, "experiment", name, command, known,
                       [](const std::string& said) { return said; });
}

}  // namespace planar
