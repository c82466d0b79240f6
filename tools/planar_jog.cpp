
#include <filesystem>
#include <iostream>
#include <sstream>

#include "planar_servo/jog/jog_console.h"
#include "planar_servo/jog/jog_keys.h"
#include "planar_servo/machine/device_kinds.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-jog",
    "Moves a cell by hand: enables, homes, jogs, shows the exposure and teaches targets.",
    "planar-jog --cell cell.yaml [--teach targets.csv]\n"
    "       printf 'enable\\njoint 2 -10\\nteach A\\n' | planar-jog --cell cell.yaml --teach "
    "targets.csv",
    "joints 0.000 70.000 10.000 deg, end point (402.605, -281.908) mm, phi -10.000 deg\n"
    "taught A at (401.981, -284.091) mm as seen"};

struct Options {
  std::filesystem::path cell, teach;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "FILE", "the cell");
  add_value(app, "--teach", options.teach, "targets.csv",
            "table of targets to append taught places to");
  app.footer(
      std::string("Commands, one a line (on a terminal: keys, and ':' before a command):\n") +
      JogConsole::help());
}

/// Executes commands, prints their answers and counts what was not done.
class Session {
 public:
  explicit Session(JogConsole& console) : console_(console) {}

  void execute(const std::string& line) {
    const JogConsole::Answer answer = console_.execute(line);
    ++commands_;
    if (!answer.done) ++refused_;
    if (!answer.text.empty()) say(answer.done ? stdout : stderr, "{}\n", answer.text);
    std::fflush(stdout);
  }

  /// Refuses a command that nothing ended.
  void refuse(const std::string& torn) {
    ++commands_;
    ++refused_;
    say(stderr,
        "'{}' does not end with a newline, so that digits may be missing; end it if it is "
        "whole\n",
        torn);
  }

  Outcome outcome() const {
    return {{{"commands", commands_}, {"refused", refused_}}, refused_ == 0};
  }

 private:
  JogConsole& console_;
  std::size_t commands_{0}, refused_{0};
};

bool ends(const std::string& command) {
  std::string verb;
  std::istringstream(command) >> verb;
  return verb == "quit";
}

void follow_lines(Session& session) {
  for (std::string line; !interrupted() && std::getline(std::cin, line) && !ends(line);)
    if (std::cin.eof())
      session.refuse(line);
    else
      session.execute(line);
}

/// Asks the arm to stop when another key is pressed than the one that began the motion.
class KeyStop {
 public:
  void watch(RawTerminal& terminal, const std::string& key) {
    terminal_ = &terminal;
    key_ = key;
  }
  bool asked() { return terminal_ != nullptr && terminal_->other_key_than(key_); }

 private:
  RawTerminal* terminal_{nullptr};
  std::string key_;
};

void follow_keys(Session& session, KeyStop& stop) {
  constexpr const char* kQuitKeys[] = {"Q", "\x03", "\x04"};
  RawTerminal terminal;
  JogKeys keys;
  say("{}\n", keys.help());
  while (const auto key = terminal.key()) {
    for (const char* quit : kQuitKeys)
      if (*key == quit) return;
    std::optional<std::string> command;
    if (*key == ":") {
      say(":");
      std::fflush(stdout);
      command = terminal.line();
      if (!command || ends(*command)) return;
    } else {
      command = keys.command(*key);
    }
    stop.watch(terminal, *key);
    if (command)
      session.execute(*command);
    else
      say("{}\n", keys.help());
    terminal.forget_keys();
  }
}

Outcome jog(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  heed_interrupts();
  const auto devices = open_cell(cell);
  KeyStop stop;
  JogConsole console(cell, *devices, options.teach,
                     [&stop] { return interrupted() || stop.asked(); });
  Session session(console);
  if (!RawTerminal::is_there()) {
    follow_lines(session);
    return session.outcome();
  }
  follow_keys(session, stop);
  return {session.outcome().figures};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::jog);
}
