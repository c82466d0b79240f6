#include "planar_servo/io/status_line.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <utility>

#include "planar_servo/core/text.h"

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

namespace {

constexpr double kShortWork_s = 1.0;
constexpr double kBetweenDrawings_s = 0.1;
constexpr std::size_t kWidth = 40;

}  // namespace

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

}  // namespace planar
