#include "planar_servo/calibration/board/board_rest.h"

#include <cmath>

namespace planar {
namespace {

constexpr double kRemembered_s = 10.0;

double distance_px(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

void BoardRest::see(double t_s, const std::vector<Eigen::Vector2d>& pixels) {
  if (pixels.empty()) return seen_.clear();
  std::size_t moved = seen_.size();
  while (moved > 0 && distance_px(seen_[moved - 1].pixels, pixels) <= bound_px_) --moved;
  seen_.erase(seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(moved));
  seen_.push_back({t_s, pixels});
  while (t_s - seen_.front().t_s > kRemembered_s) seen_.pop_front();
}

double BoardRest::still_for_s() const {
  return seen_.empty() ? 0.0 : seen_.back().t_s - seen_.front().t_s;
}

}  // namespace planar
