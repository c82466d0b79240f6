#include "planar_servo/io/terminal.h"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "planar_servo/core/error.h"
#include "planar_servo/core/text.h"
#include "planar_servo/io/csv_fields.h"

namespace planar {
namespace {

/// Where standard input was closed, a library's socket may stand in its place.
bool is_input(int descriptor) {
  struct stat kind {};
  return fstat(descriptor, &kind) == 0 && !S_ISSOCK(kind.st_mode);
}

[[noreturn]] void nobody_answers(const std::string& question, const std::string& why) {
  throw WorkError(
      {fmt::format("nobody answers '{}': {}", trimmed(question), why),
       "start the program in a terminal, or give tracker.source file or tcp with a column id"});
}

constexpr char kEraseToEnd[] = "\033[K";  // of a status line that stood there

}  // namespace

std::string Terminal::ask(const std::string& question) {
  if (!is_input(in_)) nobody_answers(question, "standard input is closed");
  if (is_attended()) tcflush(in_, TCIFLUSH);
  const std::string shown = visible(question) + (isatty(out_) != 0 ? kEraseToEnd : "");
  for (std::string_view rest = shown; !rest.empty();) {
    const ssize_t written = write(out_, rest.data(), rest.size());
    if (written <= 0) nobody_answers(question, "the question cannot be written");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  std::string line;
  for (char letter = 0;;) {
    const ssize_t n = read(in_, &letter, 1);
    if (n == 0) nobody_answers(question, "standard input has ended");
    if (n < 0 && errno == EINTR)
      throw WorkError({fmt::format("left at '{}'", trimmed(question)), "start again to continue"});
    if (n < 0) nobody_answers(question, fmt::format("standard input: {}", std::strerror(errno)));
    if (letter == '\n') return std::string(trimmed(line));
    line += letter;
  }
}

void Terminal::say(const std::string& message) {
  line_.wipe();
  spdlog::info(message);
}

void Terminal::warn(const std::string& message) {
  line_.wipe();
  spdlog::warn(message);
}

bool Terminal::entered() {
  bool pressed = false;
  pollfd input{in_, POLLIN, 0};
  while (!ended_ && is_attended() && poll(&input, 1, 0) > 0) {
    std::array<char, 256> keys{};
    const ssize_t count = read(in_, keys.data(), keys.size());
    ended_ = count <= 0;
    pressed = pressed || std::find(keys.begin(), keys.end(), '\n') != keys.end();
  }
  return pressed;
}

}  // namespace planar
