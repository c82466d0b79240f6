#include "planar_servo/jog/jog_keys.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr const char* kSteps[] = {"0.1", "1", "10"};
constexpr int kLastStep = 2;

struct MotionKey {
  const char* key;
  const char* motion;  ///< begins the command; the step follows with its sign
};

constexpr MotionKey kMotions[] = {{"\x1b[C", "x "},  {"\x1b[D", "x -"},  {"\x1b[A", "y "},
                                  {"\x1b[B", "y -"}, {"q", "joint 1 "},  {"a", "joint 1 -"},
                                  {"w", "joint 2 "}, {"s", "joint 2 -"}, {"e", "joint 3 "},
                                  {"d", "joint 3 -"}};

struct CommandKey {
  const char* key;
  const char* command;
};

constexpr CommandKey kCommands[] = {{"o", "enable"}, {"h", "home"},  {"p", "where"}, {"l", "look"},
                                    {"v", "find"},   {"f", "focus"}, {"i", "save"}};

constexpr char kEscape = '\x1b';
constexpr int kSequence_ms = 20;  // the characters of one key arrive within this time

bool more_follows(int patience_ms) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return poll(&input, 1, patience_ms) > 0;
}

/// Returns whether characters that begin with Esc are a whole key: Esc and one, or a sequence
/// Esc [ that a letter or ~ ends.
bool is_whole(const std::string& key) {
  if (key.size() < 2) return false;
  return key[1] != '[' || (key.size() > 2 && key.back() >= '@');
}

}  // namespace

std::optional<std::string> JogKeys::command(const std::string& key) const {
  for (const MotionKey& motion : kMotions)
    if (key == motion.key) return std::string(motion.motion) + kSteps[step_];
  for (const CommandKey& named : kCommands)
    if (key == named.key) return named.command;
  return std::nullopt;
}

bool JogKeys::change_step(const std::string& key) {
  if (key != "+" && key != "-") return false;
  step_ = std::clamp(step_ + (key == "+" ? 1 : -1), 0, kLastStep);
  return true;
}

std::string JogKeys::help() const {
  return fmt::format(
      "arrows: x, y   q a, w s, e d: joints 1, 2, 3   + -: {}\n"
      "o: enable   h: home   p: where   l: look   v: find the lamps in the whole frame\n"
      "f: focus until another key   i: save a whole frame   ?: all commands   Q: quit\n"
      "':': a whole command; Tab completes it, Esc leaves it, up recalls one before\n"
      "another key while the arm moves stops it",
      step());
}

std::string JogKeys::step() const {
  return fmt::format("step {} mm/deg", kSteps[step_]);
}

bool RawTerminal::is_there() {
  return isatty(STDIN_FILENO) != 0;
}

RawTerminal::RawTerminal() {
  if (tcgetattr(STDIN_FILENO, &usual_) != 0) throw WorkError("standard input is no terminal");
  termios raw = usual_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG);
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

RawTerminal::~RawTerminal() {
  tcsetattr(STDIN_FILENO, TCSANOW, &usual_);
}

std::optional<std::string> RawTerminal::key() {
  const auto first = character();
  if (!first) return std::nullopt;
  std::string key(1, *first);
  while (key[0] == kEscape && !is_whole(key) && more_follows(kSequence_ms)) {
    const auto next = character();
    if (!next) break;
    key += *next;
  }
  return key;
}

bool RawTerminal::other_key_than(const std::string& key) {
  bool other = false;
  while (more_follows(0)) {
    const auto pressed = this->key();
    if (!pressed) return true;  // the input has ended: nobody watches any more
    other = other || *pressed != key;
  }
  return other;
}

void RawTerminal::forget_keys() {
  tcflush(STDIN_FILENO, TCIFLUSH);
}

std::optional<char> RawTerminal::character() {
  char c = 0;
  return read(STDIN_FILENO, &c, 1) == 1 ? std::optional<char>(c) : std::nullopt;
}

}  // namespace planar
