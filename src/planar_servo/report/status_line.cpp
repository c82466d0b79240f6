#include "planar_servo/report/status_line.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

#include "planar_servo/core/text/visible.h"

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

}  // namespace planar
