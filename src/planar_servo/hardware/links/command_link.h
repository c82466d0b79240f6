#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/io/line_reader.h"
#include "planar_servo/hardware/links/machine_link.h"

namespace planar {

/// A user's program that moves the machine, and how long each of its answers may take.
struct MotionProgram {
  std::vector<std::string> words;  ///< the program and its arguments
  std::filesystem::path folder;    ///< where it is started
  double answer_s{0.2};
};

/// A program that runs beside this one and is spoken to by lines. Its end of a terminal's Ctrl-C is
/// this program's business. The destructor closes its standard input, then sends SIGTERM, then
/// SIGKILL, with a second between.
class ChildProgram {
 public:
  /// Throws WorkError when it cannot be started.
  explicit ChildProgram(const MotionProgram& program);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// Throws WorkError when it does not read, or has ended.
  void send(const std::string& line);
  /// Throws WorkError when no line comes within this time, or the program has ended.
  std::string next_line(double patience_s);
  /// Returns whether it has said more than was read.
  bool has_said_more() { return reader_->has_more(); }

 private:
  void start(const MotionProgram& program, int input, int output);
  bool ends_within(double patience_s);
  /// Says how the program ended, once it has closed its output.
  std::string ending();

  pid_t process_{-1};
  int status_{0};
  int input_{-1}, output_{-1};        ///< ends of its standard input and output
  std::optional<LineReader> reader_;  ///< of its standard output
};

/// Speaks the lines of doc/motion_program.md with a program of the user's own: each request begins
/// with a number, and so does its answer. A program that answers late, twice or otherwise is ended.
class CommandLink final : public MachineLink {
 public:
  /// Starts the program. Throws WorkError when that fails or it does not know the protocol.
  explicit CommandLink(const MotionProgram& program);

  void switch_on() override { ask("enable", kReadyPatience_s); }
  void go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) override;
  void stop() override { ask("stop"); }
  void search_home(int joint, HomeDirection direction) override;
  MachineState read() override;
  const char* starter() const override { return "what your program does on `move`"; }

  /// Returns what the program calls itself.
  const std::string& machine() const { return machine_; }

 private:
  static constexpr double kReadyPatience_s = 20.0;  ///< for a machine that starts or gets power

  /// Returns the words behind `ok` of the answer.
  std::string ask(const std::string& request) { return ask(request, answer_s_); }
  std::string ask(const std::string& request, double patience_s);

  ChildProgram program_;
  double answer_s_;
  int asked_{0};
  std::string machine_;
  Pulses here_{0, 0, 0};  ///< as it was read last
};

}  // namespace planar
