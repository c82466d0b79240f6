#include "planar_servo/jog/raw_terminal.h"

#include <poll.h>
#include <unistd.h>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr char kEscape = '\x1b';
constexpr int kSequence_ms = 20;  // the characters of one key arrive within this time

bool more_follows(int patience_ms) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return poll(&input, 1, patience_ms) > 0;
}

}  // namespace

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
