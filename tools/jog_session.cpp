#include "jog_session.h"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <iostream>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/jog/jog_console.h"

namespace planar {
namespace {

/// Whether a line was typed since it was last forgotten, by somebody at a terminal.
class TypedLine {
 public:
  bool is_there() const {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return at_terminal_ && poll(&input, 1, 0) > 0;
  }
  void forget() const {
    if (at_terminal_) tcflush(STDIN_FILENO, TCIFLUSH);
  }
  bool at_terminal() const { return at_terminal_; }
  bool is_typed() const { return is_typed_; }

 private:
  bool is_typed_{isatty(STDIN_FILENO) != 0};
  bool at_terminal_{is_typed_ && isatty(STDOUT_FILENO) != 0};
};

std::string verb_of(const std::string& line) {
  std::string verb;
  std::istringstream(line) >> verb;
  return verb;
}

/// Executes commands, prints their answers and counts what was not done.
class Session {
 public:
  Session(JogConsole& console, StatusLine& status, const TypedLine& typed)
      : console_(console), status_(status), typed_(typed) {}

  /// What was typed while the command ran is forgotten before its answer is shown.
  void execute(const std::string& line) {
    std::string answer, fault;
    try {
      answer = answer_to(line);
    } catch (const InputError& error) {
      fault = error.what();
    } catch (const WorkError& error) {
      fault = error.what();
    }
    typed_.forget();
    status_.wipe();
    ++commands_;
    if (!fault.empty())
      refuse(fault);
    else if (!answer.empty())
      say("{}\n", answer);
    std::fflush(stdout);
  }

  /// Refuses a command that nothing ended.
  void refuse_torn(const std::string& torn) {
    ++commands_;
    refuse(fmt::format(
        "'{}' does not end with a newline, so that digits may be missing; end it if it is whole",
        torn));
  }

  Outcome outcome() const {
    return {{{"commands", commands_}, {"refused", refused_}}, refused_ == 0};
  }

  std::string answer_to(const std::string& line) {
    if (verb_of(line) == "help") return arm_command_help();
    const auto command = parse_arm_command(line);
    return command ? console_.perform(*command) : "";
  }

 private:
  void refuse(const std::string& reason) {
    ++refused_;
    fmt::print(stderr, "{}{}\n", visible(reason),
               typed_.is_typed() ? "" : "; no command after this one is done");
  }

  JogConsole& console_;
  StatusLine& status_;
  const TypedLine& typed_;
  std::size_t commands_{0}, refused_{0};
};

}  // namespace

Outcome jog_by_lines(const CellSettings& cell, const std::filesystem::path& teach) {
  heed_interrupts();
  const auto devices = open_cell(cell);
  const TypedLine typed;
  StatusLine status;
  JogConsole console(
      read_calibrated_cell(cell), *devices, teach,
      [&] { return interrupted() || typed.is_there(); },
      [&](const std::string& sentence) { status.show(sentence + "; Enter stops the arm"); });
  Session session(console, status, typed);
  if (typed.at_terminal()) say("{}\n", arm_command_help());
  // Nobody has seen what failed who wrote the lines behind it before.
  const auto goes_on = [&] { return typed.is_typed() || session.outcome().success; };
  for (std::string line;
       !interrupted() && goes_on() && std::getline(std::cin, line) && verb_of(line) != "quit";) {
    if (std::cin.eof()) {
      session.refuse_torn(line);
      continue;
    }
    session.execute(line);
    if (!typed.at_terminal() || verb_of(line) != "focus") continue;
    while (!typed.is_there() && !interrupted())
      status.show("Enter ends this: " + session.answer_to(line));
    status.wipe();
    if (!interrupted()) std::getline(std::cin, line);
  }
  Outcome outcome = session.outcome();
  outcome.success = outcome.success || typed.is_typed();
  return outcome;
}

}  // namespace planar
