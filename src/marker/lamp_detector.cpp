#include "marker/lamp_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace planar {
namespace {

constexpr int kLeastDiameter_px = 12;
constexpr int kMostDiameter_px = 512;
// With a row in every half diameter one row passes within a quarter diameter of the centre, where
// the chord is 0.87 diameters long; half a diameter leaves room for blur and a ragged rim.
constexpr int kRowStep = kLeastDiameter_px / 2;
constexpr int kLeastRun_px = kLeastDiameter_px / 2;

constexpr int kSampledRows = 32;
constexpr double kNoiseFactor = 6.0;    // standard deviations of the background
constexpr double kLeastStep = 10.0;     // grey levels above the background
constexpr double kMadToSigma = 1.4826;  // of normal data

/// Median of |level - centre| over a histogram of levels.
int median_deviation(const std::array<int, 256>& counts, int centre, int total) {
  int within = 0;
  for (int deviation = 0; deviation < 256; ++deviation) {
    if (centre - deviation >= 0) within += counts[static_cast<std::size_t>(centre - deviation)];
    if (deviation > 0 && centre + deviation < 256) {
      within += counts[static_cast<std::size_t>(centre + deviation)];
    }
    if (2 * within >= total) return deviation;
  }
  return 255;
}

/// Some whole rows, evenly spread over the image, below one another.
cv::Mat sampled_rows(const cv::Mat& image) {
  const int rows = std::min(kSampledRows, image.rows);
  cv::Mat sample(rows, image.cols, CV_8UC1);
  for (int i = 0; i < rows; ++i) {
    image.row((2 * i + 1) * image.rows / (2 * rows)).copyTo(sample.row(i));
  }
  return sample;
}

/// Level above which a pixel may belong to a lamp: well above the background's noise; in an image
/// without an even background, between its two classes of levels [Otsu 1979].
int learn_threshold(const cv::Mat& image) {
  cv::Mat sample = sampled_rows(image);
  std::array<int, 256> counts{};
  std::for_each(sample.ptr(), sample.ptr() + sample.total(),
                [&](std::uint8_t level) { ++counts[level]; });
  const int total = static_cast<int>(sample.total());
  int background = 0, below = counts[0];
  while (2 * below < total) below += counts[static_cast<std::size_t>(++background)];
  const double sigma = kMadToSigma * median_deviation(counts, background, total);
  const double threshold = background + std::max(kNoiseFactor * sigma, kLeastStep);
  if (threshold < 0.5 * (background + 255.0)) return static_cast<int>(std::lround(threshold));
  return static_cast<int>(cv::threshold(sample, sample, 0, 255, cv::THRESH_OTSU));
}

/// First pixel at or after `u` above the threshold; `width` when there is none. Whole blocks are
/// compared at once, which the compiler turns into vector instructions.
int next_bright(const std::uint8_t* row, int u, int width, int threshold) {
  constexpr int kBlock = 64;
  while (u + kBlock <= width) {
    std::uint8_t brightest = 0;
    for (int i = 0; i < kBlock; ++i) brightest = std::max(brightest, row[u + i]);
    if (brightest > threshold) break;
    u += kBlock;
  }
  while (u < width && row[u] <= threshold) ++u;
  return u;
}

double evidence(const Blob& blob) {
  return blob.diameter_px() * blob.contrast();
}

}  // namespace

cv::Rect LampDetector::grow(const cv::Mat& image, const Span& seed, int threshold) {
  const auto flags = [&](int v) {
    return visited_.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(image.cols);
  };
  const auto add = [&](int v, int begin, int end) {
    std::fill(flags(v) + begin, flags(v) + end, std::uint8_t{1});
    spans_.push_back({v, begin, end});
  };
  int left = seed.begin, right = seed.end, top = seed.v, bottom = seed.v + 1;
  std::size_t next = spans_.size();
  add(seed.v, seed.begin, seed.end);
  for (; next < spans_.size(); ++next) {
    const Span span = spans_[next];
    left = std::min(left, span.begin);
    right = std::max(right, span.end);
    top = std::min(top, span.v);
    bottom = std::max(bottom, span.v + 1);
    if (std::max(right - left, bottom - top) > kMostDiameter_px) return {};
    for (const int v : {span.v - 1, span.v + 1}) {
      if (v < 0 || v >= image.rows) continue;
      const auto* row = image.ptr<std::uint8_t>(v);
      for (int u = span.begin; u < span.end; ++u) {
        if (row[u] <= threshold || flags(v)[u] != 0) continue;
        int begin = u, end = u + 1;
        while (begin > 0 && row[begin - 1] > threshold) --begin;
        while (end < image.cols && row[end] > threshold) ++end;
        add(v, begin, end);
        u = end;
      }
    }
  }
  return {left, top, right - left, bottom - top};
}

void LampDetector::scan_row(const cv::Mat& image, int v, int threshold, std::vector<Blob>& found) {
  const auto* row = image.ptr<std::uint8_t>(v);
  int u = next_bright(row, 0, image.cols, threshold);
  while (u < image.cols) {
    const int begin = u;
    while (u < image.cols && row[u] > threshold) ++u;
    const std::size_t first = static_cast<std::size_t>(v) * static_cast<std::size_t>(image.cols) +
                              static_cast<std::size_t>(begin);
    if (u - begin >= kLeastRun_px && visited_[first] == 0) {
      const cv::Rect box = grow(image, {v, begin, u}, threshold);
      if (std::min(box.width, box.height) >= kLeastRun_px) {
        const Blob blob = describe_blob(image, box, threshold);
        if (is_lamp_like(blob) && blob.diameter_px() >= kLeastRun_px) found.push_back(blob);
      }
    }
    u = next_bright(row, u, image.cols, threshold);
  }
}

std::vector<Blob> LampDetector::detect(const cv::Mat& image) {
  require_8_bit(image);
  if (std::min(image.cols, image.rows) < kLeastDiameter_px) return {};
  visited_.resize(image.total(), 0);
  spans_.clear();

  const int threshold = learn_threshold(image);
  std::vector<Blob> found;
  for (int v = kRowStep / 2; v < image.rows; v += kRowStep) scan_row(image, v, threshold, found);

  for (const Span& span : spans_) {
    const auto row = visited_.begin() + static_cast<std::ptrdiff_t>(span.v) * image.cols;
    std::fill(row + span.begin, row + span.end, std::uint8_t{0});
  }
  std::sort(found.begin(), found.end(),
            [](const Blob& a, const Blob& b) { return evidence(a) > evidence(b); });
  return found;
}

}  // namespace planar
