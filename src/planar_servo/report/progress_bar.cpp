#include "planar_servo/report/progress_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace planar {
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
