#include "planar_servo/hardware/links/command_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <sstream>
#include <thread>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"

namespace planar {
namespace {

/// After its input has ended, and again after SIGTERM.
constexpr double kEndPatience_s = 1.0;
constexpr char kSeeProtocol[] = "see doc/motion_program.md";

WorkError no_pipe() {
  return WorkError(fmt::format("no pipe can be opened: {}", std::strerror(errno)), Cause::kSystem);
}

}  // namespace

ChildProgram::ChildProgram(const MotionProgram& program) {
  int input[2], output[2];  // a socket, because writing to it raises no signal once it is closed
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, input) != 0) throw no_pipe();
  if (pipe2(output, O_CLOEXEC) != 0) {
    for (const int end : input) close(end);
    throw no_pipe();
  }
  input_ = input[0];
  output_ = output[0];
  reader_.emplace(output_);
  try {
    start(program, input[1], output[1]);
  } catch (...) {
    for (const int end : {input[0], input[1], output[0], output[1]}) close(end);
    throw;
  }
  close(input[1]);
  close(output[1]);
}

void ChildProgram::start(const MotionProgram& program, int input, int output) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  if (!program.folder.empty()) posix_spawn_file_actions_addchdir_np(&files, program.folder.c_str());
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t all, none;
  sigfillset(&all);
  sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  std::vector<std::string> words = program.words;
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int fault =
      posix_spawnp(&process_, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (fault == 0) return;
  throw WorkError({fmt::format("'{}' cannot be started in {}: {}", words[0],
                               program.folder.string(), std::strerror(fault)),
                   fault == EACCES || fault == ENOEXEC
                       ? "make it executable (chmod +x), or name its interpreter before it"
                       : "correct `program` in the cell file",
                   "", fault == ENOENT ? Cause::kMissing : Cause::kSystem});
}

ChildProgram::~ChildProgram() {
  close(input_);
  if (!ends_within(kEndPatience_s)) {
    kill(-process_, SIGTERM);
    if (!ends_within(kEndPatience_s)) {
      kill(-process_, SIGKILL);
      waitpid(process_, &status_, 0);
    }
  }
  close(output_);
}

bool ChildProgram::ends_within(double patience_s) {
  constexpr std::chrono::milliseconds kPoll{2};
  const std::chrono::duration<double> patience(patience_s);
  for (const auto begun = std::chrono::steady_clock::now();;) {
    if (process_ == -1) return true;
    if (waitpid(process_, &status_, WNOHANG) != 0) {
      process_ = -1;
      return true;
    }
    if (std::chrono::steady_clock::now() - begun >= patience) return false;
    std::this_thread::sleep_for(kPoll);
  }
}

std::string ChildProgram::ending() {
  if (!ends_within(kEndPatience_s)) return "it has closed its output";
  if (WIFSIGNALED(status_))
    return fmt::format("it was ended by signal {} ({})", WTERMSIG(status_),
                       strsignal(WTERMSIG(status_)));
  return fmt::format("it has ended with status {}; above is what it wrote to standard error",
                     WEXITSTATUS(status_));
}

void ChildProgram::send(const std::string& line) {
  const std::string text = line + "\n";
  const ssize_t sent = ::send(input_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent == static_cast<ssize_t>(text.size())) return;
  throw WorkError(sent < 0 && errno == EPIPE ? ending() : "it does not read what it is asked",
                  Cause::kDevice);
}

std::string ChildProgram::next_line(double patience_s) {
  const auto line = reader_->next(patience_s);
  if (line && line->size() < LineReader::kLongest) return visible(*line);
  throw WorkError(line ? "its answer never ends"
                  : reader_->ended()
                      ? ending()
                      : fmt::format("it has not answered within {:.0f} ms", patience_s * 1e3),
                  Cause::kDevice);
}

CommandLink::CommandLink(const MotionProgram& program)
    : program_(program), answer_s_(program.answer_s) {
  machine_ = ask("hello 1", kReadyPatience_s);
}

std::string CommandLink::ask(const std::string& request, double patience_s) {
  if (program_.has_said_more())
    throw WorkError({fmt::format("it says '{}' unasked", program_.next_line(patience_s)),
                     kSeeProtocol, "", Cause::kDevice});
  const std::string number = fmt::format("{} ", ++asked_);
  program_.send(number + request);
  const std::string answer = program_.next_line(patience_s);
  const auto begins = [&](const std::string& with) { return answer.rfind(with, 0) == 0; };
  if (begins(number + "no "))
    throw MachineRefusal(
        fmt::format("it refuses '{}': {}", request, answer.substr(number.size() + 3)),
        Cause::kDevice);
  if (!begins(number + "ok"))
    throw WorkError({fmt::format("it answers '{}' with '{}'", number + request, answer),
                     kSeeProtocol, "", Cause::kDevice});
  const std::size_t from = number.size() + 3;
  return answer.size() > from ? answer.substr(from) : "";
}

void CommandLink::go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) {
  const MoveTime time = time_of(counts - here_, limits);
  ask(fmt::format("move {} {:.4f} {:.4f}", fmt::join(counts, " "), time.duration_s, time.ramp_s));
}

void CommandLink::search_home(int joint, HomeDirection direction) {
  ask(fmt::format("home {} {}", joint + 1,
                  direction == HomeDirection::kForward ? "forward" : "reverse"));
}

MachineState CommandLink::read() {
  const std::string answer = ask("where");
  std::istringstream text(answer);
  MachineState state;
  std::string motion, fault;
  for (int i = 0; i < 3; ++i) text >> state.counts[i];
  text >> motion >> state.losses;
  const bool is_known =
      motion == "off" || motion == "resting" || motion == "moving" || motion == "homing";
  if (!text || !is_known)
    throw WorkError({fmt::format("it answers 'where' with '{}'; {}", answer,
                                 is_known || motion.empty()
                                     ? "counts and LOSSES must be whole numbers of 32 bits"
                                     : "MOTION must be off, resting, moving or homing"),
                     kSeeProtocol, "", Cause::kDevice});
  std::getline(text >> std::ws, fault);
  state.on = motion != "off";
  state.moving = motion == "moving" || motion == "homing";
  state.homing = motion == "homing";
  state.mover = fmt::format("it says '{}'", answer);
  if (!fault.empty()) state.faults.push_back(fault);
  here_ = state.counts;
  return state;
}

}  // namespace planar
