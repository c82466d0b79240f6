#include "planar_servo/machine/rehearsal/firmware_board.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr double kAnswerPatience_s = 10.0;
constexpr double kEndPatience_s = 10.0;
constexpr double kPause_s = 0.02;
constexpr char kEnd = '\x06';
constexpr char kQuestion = '?';
constexpr double kAskPeriod_s = 0.01;
/// Reports come unevenly, so that the motors seem to be faster than they are; a report that has
/// them still faster is garbled.
constexpr double kSeemingSpeed = 2.0;
constexpr double kSeemingTime_s = 0.05;

fs::path checked_program(const fs::path& simulator) {
  fs::path program = fs::absolute(simulator);
  if (fs::is_regular_file(program) && access(program.c_str(), X_OK) == 0) return program;
  throw InputError({"is no program that can be run", "name Grbl's simulator, such as grbl_sim",
                    simulator, Cause::kMissing});
}

std::vector<std::string> commands_of(const EmulatedGrbl::Settings& settings) {
  std::vector<std::string> commands;
  for (const auto& [number, value] : settings)
    commands.push_back(fmt::format("${}={:.9g}", number, value));
  return commands;
}

}  // namespace

PassingFolder::PassingFolder(const std::string& name) {
  std::string pattern = (fs::temp_directory_path() / (name + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw WorkError({"no folder can be made there", "is the disk full?", pattern, Cause::kSystem});
  path_ = pattern;
}

PassingFolder::~PassingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

FirmwareProcess::FirmwareProcess(const fs::path& simulator, const std::vector<std::string>& options,
                                 const std::vector<std::string>& commands)
    : FirmwareProcess(simulator, options) {
  banner_ = wait_for("Grbl", "its start");
  for (const std::string& command : commands) {
    line_.write(command + "\n");
    wait_for("ok", command);
  }
}

FirmwareProcess::~FirmwareProcess() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

/// Its input has no buffer, because the simulator of Grbl reads on from a buffer only when more
/// comes. It stands at the outer end of the line, because it sets up its terminal for each byte, by
/// which a program that waits there would be woken 20,000 times a second. It has a session of its
/// own, so that Ctrl-C in this program's terminal does not reach it.
FirmwareProcess::FirmwareProcess(const fs::path& simulator, const std::vector<std::string>& options)
    : simulator_(checked_program(simulator)), line_(folder_.path() / "port") {
  std::vector<std::string> words{"stdbuf", "-i0", simulator_.string(), "-n", "-b", "/dev/null"};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, line_.outer(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, line_.outer(), STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawn_file_actions_addchdir_np(&files, folder_.path().c_str());
  posix_spawnattr_t session;
  posix_spawnattr_init(&session);
  posix_spawnattr_setflags(&session, POSIX_SPAWN_SETSID);
  const int fault = posix_spawnp(&process_, "stdbuf", &files, &session, arguments.data(), environ);
  posix_spawnattr_destroy(&session);
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0)
    throw WorkError({simulator_.string() + " cannot be started by stdbuf",
                     "install coreutils, which has stdbuf", "", Cause::kMissing});
}

std::string FirmwareProcess::wait_for(std::string_view beginning, const std::string& purpose) {
  SteadyClock clock;
  const double deadline_s = clock.now_s() + kAnswerPatience_s;
  while (clock.now_s() < deadline_s) {
    require_running();
    for (auto end = heard_.find('\n'); end != std::string::npos; end = heard_.find('\n')) {
      std::string line = heard_.substr(0, heard_.find_last_not_of('\r', end - 1) + 1);
      heard_.erase(0, end + 1);
      if (line.rfind(beginning, 0) == 0) return line;
    }
    heard_ += line_.read(kPause_s);
  }
  throw WorkError({fmt::format("{} has not answered {} with '{}' within {:g} s",
                               simulator_.string(), purpose, beginning, kAnswerPatience_s),
                   "name Grbl's simulator, such as grbl_sim", "", Cause::kDevice});
}

void FirmwareProcess::require_running() {
  int status = 0;
  if (process_ > 0 && waitpid(process_, &status, WNOHANG) == 0) return;
  process_ = -1;
  throw WorkError(
      fmt::format("{} has ended {}; start it again", simulator_.string(),
                  WIFSIGNALED(status) ? fmt::format("by signal {}", WTERMSIG(status))
                                      : fmt::format("with status {}", WEXITSTATUS(status))),
      Cause::kDevice);
}

void FirmwareProcess::end() {
  if (process_ <= 0) return;
  line_.write({&kEnd, 1});
  SteadyClock clock;
  const double deadline_s = clock.now_s() + kEndPatience_s;
  while (waitpid(process_, nullptr, WNOHANG) == 0) {
    if (clock.now_s() > deadline_s) kill(process_, SIGKILL);
    clock.sleep_for_s(kPause_s);
  }
  process_ = -1;
}

FirmwareBoard::FirmwareBoard(const std::filesystem::path& simulator,
                             const std::vector<std::string>& options,
                             const EmulatedGrbl::Settings& settings,
                             const std::filesystem::path& port,
                             EmulatedGrbl::OnPosition on_position)
    : firmware_(simulator, options, commands_of(settings)),
      port_(port),
      pulses_per_mm_(EmulatedGrbl::of_axes(settings, 100)),
      pulses_per_s_(EmulatedGrbl::of_axes(settings, 110).cwiseProduct(pulses_per_mm_) / 60.0),
      on_position_(std::move(on_position)),
      placed_s_(clock_.now_s()) {
  relay_.emplace(0.0, [this] { carry(); });
}

const std::filesystem::path& FirmwareBoard::end() {
  relay_.reset();
  firmware_.end();
  return firmware_.folder();
}

void FirmwareBoard::carry() {
  pollfd lines[] = {{port_.inner(), POLLIN, 0}, {firmware_.line().inner(), POLLIN, 0}};
  poll(lines, std::size(lines), static_cast<int>(1e3 * kAskPeriod_s));
  firmware_.require_running();
  carry_to_firmware();
  carry_to_program();
}

void FirmwareBoard::carry_to_firmware() {
  std::string bytes = port_.read(0.0);
  if (bytes.find(kQuestion) != std::string::npos) asked_ = true;
  const double now_s = clock_.now_s();
  if (now_s - last_question_s_ >= kAskPeriod_s) bytes += kQuestion;
  if (bytes.find(kQuestion) != std::string::npos) last_question_s_ = now_s;
  firmware_.line().write(bytes);
}

/// Hands on whole lines, but no report that the program did not ask for.
void FirmwareBoard::carry_to_program() {
  heard_ += firmware_.line().read(0.0);
  for (auto end = heard_.find('\n'); end != std::string::npos; end = heard_.find('\n')) {
    const std::string line = heard_.substr(0, end + 1);
    heard_.erase(0, end + 1);
    const bool report = line.front() == '<';
    if (report) note(line);
    if (!report || asked_) port_.write(line);
    if (report) asked_ = false;
  }
}

void FirmwareBoard::note(const std::string& report) {
  Eigen::Vector3d place_mm;
  const std::size_t at = report.find("|MPos:");
  if (at == std::string::npos || std::sscanf(report.c_str() + at, "|MPos:%lf,%lf,%lf|",
                                             &place_mm[0], &place_mm[1], &place_mm[2]) != 3)
    return;
  const EmulatedGrbl::Pulses shafts =
      place_mm.cwiseProduct(pulses_per_mm_).array().round().cast<int>();
  const double now_s = clock_.now_s();
  const Eigen::Vector3d farthest =
      kSeemingSpeed * pulses_per_s_ * (now_s - placed_s_ + kSeemingTime_s);
  if (((shafts - shafts_).cwiseAbs().cast<double>() - farthest).maxCoeff() > 0.0) return;
  placed_s_ = now_s;
  rests_ = report.rfind("<Idle", 0) == 0 || report.rfind("<Alarm", 0) == 0;
  if (shafts != shafts_ && on_position_) on_position_(shafts);
  shafts_ = shafts;
}

}  // namespace planar
