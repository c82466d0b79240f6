
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <sstream>

#include "planar_servo/io/status_line.h"
#include "planar_servo/jog/command_line.h"
#include "planar_servo/jog/jog_console.h"
#include "planar_servo/jog/jog_keys.h"
#include "planar_servo/machine/device_kinds.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-jog",
    "planar-jog --cell cell.yaml [--teach targets.csv]\n"
    "       printf 'enable\\njoint 2 -10\\nteach A\\n' | planar-jog --cell cell.yaml --teach "
    "targets.csv",
    "joints 0.000 70.000 10.000 deg, end point (402.605, -281.908) mm, phi -10.000 deg\n"
    "taught A at (401.981, -284.091) mm as seen"};

struct Options {
  std::filesystem::path cell, teach;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_value(app, "--teach", options.teach, "targets.csv",
            "table of targets to append taught places to");
  app.footer(
      std::string("Commands, one a line (on a terminal: keys, and ':' before a command):\n") +
      JogConsole::help());
}

/// The lines at the bottom of the terminal of somebody who jogs by keys; nothing anywhere else.
class BottomLines {
 public:
  void show(const std::string& text) {
    if (is_shown()) line_.show(text);
  }
  void wipe() { line_.wipe(); }
  /// Lets all that follows begin at the bottom.
  void go_there() const {
    if (is_shown()) fmt::print(stderr, "\033[999B");
  }
  bool is_shown() const { return shown_ && line_.is_shown(); }

 private:
  StatusLine line_;
  bool shown_{RawTerminal::is_there() && isatty(STDOUT_FILENO) != 0};
};

/// Executes commands, prints their answers and counts what was not done.
class Session {
 public:
  Session(JogConsole& console, BottomLines& bottom) : console_(console), bottom_(bottom) {}

  void execute(const std::string& line) {
    const JogConsole::Answer answer = console_.execute(line);
    bottom_.wipe();
    ++commands_;
    if (!answer.done)
      refuse(answer.text);
    else if (!answer.text.empty())
      say("{}\n", answer.text);
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

 private:
  void refuse(const std::string& reason) {
    ++refused_;
    fmt::print(stderr, "{}\n", visible(reason));
  }

  JogConsole& console_;
  BottomLines& bottom_;
  std::size_t commands_{0}, refused_{0};
};

std::string verb_of(const std::string& command) {
  std::string verb;
  std::istringstream(command) >> verb;
  return verb;
}

bool ends(const std::string& command) {
  return verb_of(command) == "quit";
}

void follow_lines(Session& session) {
  for (std::string line; !interrupted() && std::getline(std::cin, line) && !ends(line);)
    if (std::cin.eof())
      session.refuse_torn(line);
    else
      session.execute(line);
}

/// Asks the arm to stop when a key other than the one that began the motion is pressed.
class KeyStop {
 public:
  void watch(RawTerminal& terminal, const std::string& key) {
    terminal_ = &terminal;
    key_ = key;
    asked_ = false;
  }
  bool asked() {
    asked_ = asked_ || (terminal_ != nullptr && terminal_->other_key_than(key_));
    return asked_;
  }

 private:
  RawTerminal* terminal_{nullptr};
  std::string key_;
  bool asked_{false};
};

/// Follows the keys of a terminal.
class Keyboard {
 public:
  Keyboard(JogConsole& console, Session& session, BottomLines& bottom, KeyStop& stop)
      : console_(console),
        session_(session),
        bottom_(bottom),
        stop_(stop),
        line_([&console](const std::string& begun) { return console.completions(begun); }) {}

  void follow() {
    bottom_.go_there();
    tell(keys_.help());
    for (show_state(); const auto key = terminal_.key(); show_state()) {
      if (*key == "Q" || *key == kInterrupt || *key == kEndOfInput) return;
      if (keys_.change_step(*key)) {
        if (!bottom_.is_shown()) tell(keys_.step());
        continue;
      }
      const std::optional<std::string> command = *key == ":" ? typed() : keys_.command(*key);
      if (ended_ || (command && ends(*command))) return;
      stop_.watch(terminal_, *key);
      if (command)
        execute(*command);
      else if (*key != ":")
        tell(*key == "?" ? keys_.help() + '\n' + JogConsole::help()
                         : fmt::format("there is no key '{}'; ? shows the keys", *key));
      terminal_.forget_keys();
    }
  }

 private:
  static constexpr char kInterrupt[] = "\x03", kEndOfInput[] = "\x04";

  void tell(const std::string& text) {
    bottom_.wipe();
    say("{}\n", text);
    std::fflush(stdout);
  }

  void show_state() {
    if (!bottom_.is_shown()) return;
    const auto [arm, camera] = console_.status();
    bottom_.show(fmt::format("{}\n{} | {}", arm, keys_.step(), camera));
  }

  /// Lets a command be typed. Empty when it is left, or when the input ends.
  std::optional<std::string> typed() {
    constexpr char kErase[] = "\r\033[K";
    bottom_.wipe();
    line_.begin();
    auto state = CommandLine::State::kOpen;
    while (state == CommandLine::State::kOpen) {
      fmt::print(stderr, "{}:{}", kErase, visible(line_.text()));
      const auto key = terminal_.key();
      ended_ = !key || *key == kInterrupt || *key == kEndOfInput;
      state = ended_ ? CommandLine::State::kLeft : line_.take(*key);
      if (line_.choices().empty()) continue;
      fmt::print(stderr, kErase);
      tell(fmt::format("{}", fmt::join(line_.choices(), "  ")));
    }
    const bool entered = state == CommandLine::State::kEntered;
    fmt::print(stderr, "{}", entered ? "\n" : kErase);
    return entered ? std::optional<std::string>(line_.text()) : std::nullopt;
  }

  void execute(const std::string& command) {
    if (bottom_.is_shown() && verb_of(command) == "focus") repeat(command);
    session_.execute(command);
  }

  /// Shows a reading again and again until another key is pressed.
  void repeat(const std::string& command) {
    do {
      bottom_.show(console_.execute(command).text + "\nanother key ends this");
    } while (!interrupted() && !stop_.asked());
  }

  JogConsole& console_;
  Session& session_;
  BottomLines& bottom_;
  KeyStop& stop_;
  RawTerminal terminal_;
  JogKeys keys_;
  CommandLine line_;
  bool ended_{false};
};

Outcome jog(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  heed_interrupts();
  const auto devices = open_cell(cell);
  KeyStop stop;
  BottomLines bottom;
  JogConsole console(
      cell, *devices, options.teach, [&stop] { return interrupted() || stop.asked(); },
      [&bottom](const std::string& sentence) { bottom.show(sentence + "\na key stops the arm"); });
  Session session(console, bottom);
  if (!RawTerminal::is_there()) {
    follow_lines(session);
    return session.outcome();
  }
  Keyboard(console, session, bottom, stop).follow();
  return {session.outcome().figures};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::jog);
}
