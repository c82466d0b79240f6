#include "marker/blob.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/units.h"

namespace planar {
namespace {

constexpr double kLeastContrast = 20.0;  // grey levels; dimmer patches are not told from clutter
constexpr double kLeastAxisRatio = 0.3;  // a disc seen 70 degrees off its axis
constexpr double kLeastFill = 0.88;      // a square has 0.95, a half moon about 0.8

/// Counts of grey levels.
class Histogram {
 public:
  void add(std::uint8_t level) {
    ++counts_[level];
    ++total_;
  }
  bool empty() const { return total_ == 0; }
  int median() const {
    int below = 0;
    for (int level = 0; level < 256; ++level) {
      below += counts_[static_cast<std::size_t>(level)];
      if (2 * below >= total_) return level;
    }
    return 0;
  }

 private:
  std::array<int, 256> counts_{};
  int total_{0};
};

/// Levels of the pixels above the threshold, or of the others.
Histogram levels(const cv::Mat& patch, int threshold, bool above) {
  Histogram histogram;
  for (int v = 0; v < patch.rows; ++v) {
    const auto* row = patch.ptr<std::uint8_t>(v);
    for (int u = 0; u < patch.cols; ++u) {
      if ((row[u] > threshold) == above) histogram.add(row[u]);
    }
  }
  return histogram;
}

/// Levels along a frame round the box, far enough out to miss the blurred rim, as far as it lies in
/// the image.
Histogram surrounding_levels(const cv::Mat& image, const cv::Rect& box) {
  const int margin = 3 + std::max(box.width, box.height) / 10;
  const cv::Rect outer(box.x - margin, box.y - margin, box.width + 2 * margin,
                       box.height + 2 * margin);
  Histogram histogram;
  const auto add = [&](int u, int v) {
    if (u >= 0 && v >= 0 && u < image.cols && v < image.rows) {
      histogram.add(image.at<std::uint8_t>(v, u));
    }
  };
  for (int u = outer.x; u < outer.br().x; ++u) {
    add(u, outer.y);
    add(u, outer.br().y - 1);
  }
  for (int v = outer.y + 1; v < outer.br().y - 1; ++v) {
    add(outer.x, v);
    add(outer.br().x - 1, v);
  }
  return histogram;
}

/// The box of a lamp that fills the image has no surroundings: then what is dark in the box; 255,
/// against which nothing stands out, when nothing is.
int background_level(const cv::Mat& image, const cv::Rect& box, int threshold) {
  const Histogram surroundings = surrounding_levels(image, box);
  if (!surroundings.empty()) return surroundings.median();
  const Histogram dark = levels(image(box), threshold, false);
  return dark.empty() ? 255 : dark.median();
}

}  // namespace

double Blob::diameter_px() const {
  return 2.0 * std::sqrt(area_px2 / kPi);
}

double Blob::axis_ratio() const {
  const double mean = 0.5 * second_moments_px2.trace();
  const double spread = std::sqrt(std::max(0.0, mean * mean - second_moments_px2.determinant()));
  return std::sqrt(std::max(0.0, mean - spread) / (mean + spread));
}

double Blob::fill() const {
  return area_px2 / (4.0 * kPi * std::sqrt(second_moments_px2.determinant()));
}

Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, int threshold) {
  const cv::Mat patch = image(box_px);
  Blob blob;
  blob.box_px = box_px;
  blob.level = levels(patch, threshold, true).median();
  blob.background = background_level(image, box_px, threshold);
  blob.touches_border =
      box_px.x <= 0 || box_px.y <= 0 || box_px.br().x >= image.cols || box_px.br().y >= image.rows;

  const double half_way = 0.5 * (blob.level + blob.background);
  double n = 0.0, saturated = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d sum_of_squares = Eigen::Matrix2d::Zero();
  for (int v = 0; v < patch.rows; ++v) {
    const auto* row = patch.ptr<std::uint8_t>(v);
    for (int u = 0; u < patch.cols; ++u) {
      if (row[u] < half_way) continue;
      const Eigen::Vector2d p(u, v);
      n += 1.0;
      saturated += row[u] == 255 ? 1.0 : 0.0;
      sum += p;
      sum_of_squares += p * p.transpose();
    }
  }
  const Eigen::Vector2d mean = sum / n;
  blob.uv_px = mean + Eigen::Vector2d(box_px.x, box_px.y);
  // A pixel is a square of side 1, with second moments of 1/12 of its own.
  blob.second_moments_px2 =
      sum_of_squares / n - mean * mean.transpose() + Eigen::Matrix2d::Identity() / 12.0;
  blob.area_px2 = n;
  blob.saturated_share = saturated / n;
  return blob;
}

bool is_filled(const Blob& blob) {
  return blob.contrast() >= kLeastContrast && (blob.touches_border || blob.fill() >= kLeastFill);
}

bool is_lamp_like(const Blob& blob) {
  return is_filled(blob) && (blob.touches_border || blob.axis_ratio() >= kLeastAxisRatio);
}

void require_8_bit(const cv::Mat& image) {
  if (!image.empty() && image.type() != CV_8UC1) {
    throw std::invalid_argument("lamps are looked for in 8-bit images of one channel only");
  }
}

}  // namespace planar
