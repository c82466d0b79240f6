#include "planar_servo/report/status_line.h"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "planar_servo/core/text.h"

namespace planar {
namespace {

constexpr std::size_t kUsualWidth = 80;
constexpr char kEraseToEnd[] = "\033[K";

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return kUsualWidth;
  return size.ws_col;
}

}  // namespace

StatusLine::StatusLine()
    : shown_(isatty(STDERR_FILENO) != 0 && spdlog::should_log(spdlog::level::info)) {}

void StatusLine::show(const std::string& text) {
  if (!shown_) return;
  fmt::print(stderr, "\r{}{}\r", visible(text).substr(0, terminal_width() - 1), kEraseToEnd);
  drawn_ = true;
}

void StatusLine::wipe() {
  if (drawn_) fmt::print(stderr, "\r{}", kEraseToEnd);
  drawn_ = false;
}

void OperatorLine::say(const std::string& message) {
  line_.wipe();
  spdlog::info(message);
}

void OperatorLine::warn(const std::string& message) {
  line_.wipe();
  spdlog::warn(message);
}

bool OperatorLine::entered() {
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
