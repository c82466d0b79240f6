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

constexpr char kEscape = '\x1b';
constexpr int kSequence_ms = 20;  // the characters of one key arrive within this time

bool more_follows(int patience_ms) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return poll(&input, 1, patience_ms) > 0;
}

}  // namespace

std::optional<std::string> JogKeys::command(const std::string& key) {
  for (const MotionKey& motion : kMotions)
    if (key == motion.key) return std::string(motion.motion) + kSteps[step_];
  if (key == "+") step_ = std::min(step_ + 1, kLastStep);
  if (key == "-") step_ = std::max(step_ - 1, 0);
  if (key == "o") return "enable";
  if (key == "h") return "home";
  if (key == "p") return "where";
  if (key == "l") return "look";
  return std::nullopt;
}

std::string JogKeys::help() const {
  return fmt::format(
      "arrows: x, y   q a, w s, e d: joints 1, 2, 3   + -: step ({0} mm or {0} deg)\n"
      "o: enable   h: home   p: where   l: look   ':': a whole command   Q: quit\n"
      "another key while the arm moves stops it",
      kSteps[step_]);
}

bool RawTerminal::is_there() {
  return isatty(STDIN_FILENO) != 0;
}

RawTerminal::RawTerminal() {
  if (tcgetattr(STDIN_FILENO, &usual_) != 0) throw WorkError("standard input is no terminal");
  raw_ = usual_;
  raw_.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG);
  raw_.c_cc[VMIN] = 1;
  raw_.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw_);
}

RawTerminal::~RawTerminal() {
  tcsetattr(STDIN_FILENO, TCSANOW, &usual_);
}

std::optional<std::string> RawTerminal::key() {
  const auto first = character();
  if (!first) return std::nullopt;
  std::string key(1, *first);
  while (key[0] == kEscape && key.size() < 3 && more_follows(kSequence_ms)) {
    const auto next = character();
    if (!next) break;
    key += *next;
  }
  return key;
}

std::optional<std::string> RawTerminal::line() {
  tcsetattr(STDIN_FILENO, TCSANOW, &usual_);
  std::string text;
  std::optional<char> next;
  while ((next = character()) && *next != '\n') text += *next;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw_);
  return next ? std::optional<std::string>(text) : std::nullopt;
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
