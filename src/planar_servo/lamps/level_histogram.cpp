#include "planar_servo/lamps/level_histogram.h"

#include <cstddef>
#include <numeric>

namespace planar {
namespace {

constexpr int kLevels = 256;

}  // namespace

int LevelHistogram::median() const {
  return median(0, kLevels - 1);
}

int LevelHistogram::count(int lowest, int highest) const {
  return std::accumulate(counts_.begin() + lowest, counts_.begin() + highest + 1, 0);
}

int LevelHistogram::median(int lowest, int highest) const {
  const int total = count(lowest, highest);
  int up_to = 0;
  for (int level = lowest; total > 0; ++level) {
    up_to += counts_[static_cast<std::size_t>(level)];
    if (2 * up_to >= total) return level;
  }
  return 0;
}

int LevelHistogram::median_deviation(int level) const {
  const auto count = [&](int at) {
    return at >= 0 && at < kLevels ? counts_[static_cast<std::size_t>(at)] : 0;
  };
  int deviation = 0, within = count(level);
  while (2 * within < total_) {
    ++deviation;
    within += count(level - deviation) + count(level + deviation);
  }
  return deviation;
}

int LevelHistogram::otsu() const {
  double sum = 0.0;
  for (int i = 0; i < kLevels; ++i) sum += 1.0 * i * counts_[static_cast<std::size_t>(i)];
  double low_count = 0.0, low_sum = 0.0, most = -1.0;
  int best = 0;
  for (int i = 0; i < kLevels; ++i) {
    low_count += counts_[static_cast<std::size_t>(i)];
    low_sum += 1.0 * i * counts_[static_cast<std::size_t>(i)];
    const double high_count = total_ - low_count;
    if (low_count <= 0.0 || high_count <= 0.0) continue;
    const double apart = low_sum / low_count - (sum - low_sum) / high_count;
    const double between = low_count * high_count * apart * apart;
    if (between > most) {
      most = between;
      best = i;
    }
  }
  return best;
}

}  // namespace planar
