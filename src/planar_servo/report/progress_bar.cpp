#include "planar_servo/report/progress_bar.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace planar {
namespace {

constexpr double kShortWork_s = 1.0;
constexpr double kBetweenDrawings_s = 0.1;
constexpr std::size_t kWidth = 40;

}  // namespace

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)),
      wanted_(isatty(STDERR_FILENO) != 0 && spdlog::should_log(spdlog::level::info)),
      draw_after_s_(clock_.now_s() + kShortWork_s) {}

ProgressBar::~ProgressBar() {
  if (drawn_ == 0) return;
  std::fprintf(stderr, "\r%*s\r", static_cast<int>(drawn_), "");
}

void ProgressBar::show(std::size_t done, std::size_t all) {
  if (all == 0) return;
  draw(label_, static_cast<double>(done) / static_cast<double>(all),
       fmt::format("{}/{}", done, all));
}

void ProgressBar::show(const std::string& phase, double share) {
  draw(phase, share, fmt::format("{:.0f} %", 100.0 * share));
}

void ProgressBar::draw(const std::string& label, double share, const std::string& figure) {
  if (!wanted_ || clock_.now_s() < draw_after_s_) return;
  const auto filled = static_cast<std::size_t>(kWidth * std::clamp(share, 0.0, 1.0));
  const std::string bar = fmt::format("{} [{}{}] {}", label, std::string(filled, '='),
                                      std::string(kWidth - filled, ' '), figure);
  fmt::print(stderr, "\r{:<{}}", bar, drawn_);
  drawn_ = std::max(drawn_, bar.size());
  draw_after_s_ = clock_.now_s() + kBetweenDrawings_s;
}

}  // namespace planar
