#include "planar_servo/base/io/terminal.h"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {
namespace {

constexpr std::size_t kUsualWidth = 80;
/// What follows the cursor on its line, and what is below as well.
constexpr char kEraseLine[] = "\033[K", kEraseBelow[] = "\033[J";

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return kUsualWidth;
  return size.ws_col;
}

/// Where standard input was closed, a library's socket may stand in its place.
bool is_input(int descriptor) {
  struct stat kind {};
  return fstat(descriptor, &kind) == 0 && !S_ISSOCK(kind.st_mode);
}

[[noreturn]] void nobody_answers(const std::string& question, const std::string& why) {
  throw WorkError(
      {fmt::format("nobody answers '{}': {}", trimmed(question), why),
       "start the program in a terminal, or give tracker.source file or tcp with a column id", "",
       Cause::kMissing});
}

constexpr double kShortWork_s = 1.0;
constexpr double kBetweenDrawings_s = 0.1;
constexpr std::size_t kWidth = 40;

}  // namespace

StatusLine::StatusLine()
    : shown_(isatty(STDERR_FILENO) != 0 && spdlog::should_log(spdlog::level::info)) {}

void StatusLine::show(const std::string& text) {
  if (!shown_) return;
  fmt::print(stderr, "\r{}{}\r", visible(text).substr(0, terminal_width() - 1), kEraseLine);
  drawn_ = true;
}

void StatusLine::wipe() {
  if (drawn_) fmt::print(stderr, "\r{}", kEraseBelow);
  drawn_ = false;
}

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), draw_after_s_(clock_.now_s() + kShortWork_s) {}

void ProgressBar::show(std::size_t done, std::size_t all) {
  if (all == 0) return;
  draw(label_, static_cast<double>(done) / static_cast<double>(all),
       fmt::format("{}/{}", done, all));
}

void ProgressBar::show(const std::string& phase, double share) {
  draw(phase, share, fmt::format("{:.0f} %", 100.0 * share));
}

void ProgressBar::draw(const std::string& label, double share, const std::string& figure) {
  if (!line_.is_shown() || clock_.now_s() < draw_after_s_) return;
  const auto filled = static_cast<std::size_t>(kWidth * std::clamp(share, 0.0, 1.0));
  line_.show(fmt::format("{} [{}{}] {}", label, std::string(filled, '='),
                         std::string(kWidth - filled, ' '), figure));
  draw_after_s_ = clock_.now_s() + kBetweenDrawings_s;
}

std::string Terminal::ask(const std::string& question) {
  if (!is_input(in_)) nobody_answers(question, "standard input is closed");
  if (is_attended()) tcflush(in_, TCIFLUSH);
  const std::string shown = visible(question) + (isatty(out_) != 0 ? kEraseLine : "");
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
      throw WorkError({fmt::format("left at '{}'", trimmed(question)), "start again to continue",
                       "", Cause::kStopped});
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
