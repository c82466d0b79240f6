#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace planar {

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressBar::show(std::size_t done, std::size_t all) const {
  if (!terminal_ || all == 0) return;
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = kWidth * done / all;
  fmt::print(stderr, "\r{} [{}{}] {}/{}{}", label_, std::string(filled, '='),
             std::string(kWidth - filled, ' '), done, all, done == all ? "\n" : "");
}

}  // namespace planar
