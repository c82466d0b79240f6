#include "planar_servo/virtual_cell/polygon_coverage.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar {
namespace {

/// Collects for each pixel by how much more of it than of the pixel before is covered. A last
/// column beyond the window takes what begins right of it.
class AreaAccumulator {
 public:
  explicit AreaAccumulator(cv::Size size)
      : size_(size), growth_(size.height, size.width + 1, 0.0) {}

  /// Adds an edge in coordinates whose origin is the window's corner. Upward edges count negative.
  void add_edge(Eigen::Vector2d from, Eigen::Vector2d to) {
    if (from.y() == to.y()) return;
    const double sign = from.y() < to.y() ? 1.0 : -1.0;
    if (sign < 0.0) std::swap(from, to);
    const double slope = (to.x() - from.x()) / (to.y() - from.y());
    const double top = std::max(from.y(), 0.0);
    const double bottom = std::min(to.y(), static_cast<double>(size_.height));
    const auto x_at = [&](double y) { return from.x() + slope * (y - from.y()); };
    for (double y = top; y < bottom;) {
      const double y_next = std::min(std::floor(y) + 1.0, bottom);
      add_in_row(static_cast<int>(y), sign * (y_next - y), x_at(y), x_at(y_next));
      y = y_next;
    }
  }

  cv::Mat1f coverage() const {
    cv::Mat1f covered(size_);
    for (int row = 0; row < size_.height; ++row) {
      double sum = 0.0;
      for (int column = 0; column < size_.width; ++column) {
        sum += growth_(row, column);
        covered(row, column) = static_cast<float>(std::abs(sum));
      }
    }
    return covered;
  }

 private:
  /// Adds a piece of an edge inside one row, of signed height, from x0 to x1, split at the columns.
  void add_in_row(int row, double height, double x0, double x1) {
    if (x0 > x1) std::swap(x0, x1);
    const double width = static_cast<double>(size_.width);
    const double left = std::clamp(x0, 0.0, width);
    const double right = std::clamp(x1, 0.0, width);
    if (right == left) {
      add_in_column(row, height, left, left);
      return;
    }
    const double height_per_x = height / (x1 - x0);
    if (x0 < left) add_in_column(row, height_per_x * (left - x0), left, left);
    if (x1 > right) add_in_column(row, height_per_x * (x1 - right), right, right);
    for (double x = left; x < right;) {
      const double x_next = std::min(std::floor(x) + 1.0, right);
      add_in_column(row, height_per_x * (x_next - x), x, x_next);
      x = x_next;
    }
  }

  /// Adds a piece inside one pixel: the pixel is covered right of the piece, all later ones wholly.
  void add_in_column(int row, double height, double x0, double x1) {
    const int column = static_cast<int>(x0);
    const double here = height * (column + 1.0 - 0.5 * (x0 + x1));
    growth_(row, column) += here;
    if (column < size_.width) growth_(row, column + 1) += height - here;
  }

  cv::Size size_;
  cv::Mat1d growth_;
};

}  // namespace

cv::Mat1f polygon_coverage(const std::vector<Eigen::Vector2d>& outline_px,
                           const cv::Rect& window_px) {
  AreaAccumulator area(window_px.size());
  const Eigen::Vector2d corner(window_px.x - 0.5, window_px.y - 0.5);
  for (std::size_t i = 0; i < outline_px.size(); ++i)
    area.add_edge(outline_px[i] - corner, outline_px[(i + 1) % outline_px.size()] - corner);
  return area.coverage();
}

cv::Rect window_around(const std::vector<Eigen::Vector2d>& outline_px, double margin_px) {
  Eigen::Vector2d lower = outline_px.front();
  Eigen::Vector2d upper = outline_px.front();
  for (const Eigen::Vector2d& point : outline_px) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  const int left = static_cast<int>(std::floor(lower.x() - margin_px));
  const int top = static_cast<int>(std::floor(lower.y() - margin_px));
  const int right = static_cast<int>(std::ceil(upper.x() + margin_px));
  const int bottom = static_cast<int>(std::ceil(upper.y() + margin_px));
  return {left, top, right - left + 1, bottom - top + 1};
}

}  // namespace planar
