#include "planar_servo/lamps/blob.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {

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

namespace {

constexpr double kLeastAxisRatio = 0.3;  // a disc seen 70 degrees off its axis has 0.34
constexpr double kLeastFill = 0.88;      // a square has 0.95, a half moon about 0.8

LevelHistogram levels_in(const cv::Mat& image, const Span* begin, const Span* end) {
  LevelHistogram histogram;
  for (const Span* span = begin; span != end; ++span) {
    const auto* row = image.ptr<std::uint8_t>(span->v);
    histogram.add(row + span->begin, row + span->end);
  }
  return histogram;
}

std::vector<Span> rows_of(const cv::Rect& box) {
  std::vector<Span> rows;
  for (int v = box.y; v < box.br().y; ++v) rows.push_back({v, box.x, box.br().x});
  return rows;
}

/// Returns the levels along a frame around the box, far enough out to miss the blurred rim, as far
/// as it lies in the image.
LevelHistogram surrounding_levels(const cv::Mat& image, const cv::Rect& box) {
  const int margin = 3 + std::max(box.width, box.height) / 10;
  const cv::Rect outer = box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin);
  LevelHistogram histogram;
  const auto add = [&](int u, int v) {
    if (u >= 0 && v >= 0 && u < image.cols && v < image.rows)
      histogram.add(image.at<std::uint8_t>(v, u));
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

/// Returns the median level around the box. Where a lamp fills the image, it is the median of the
/// box's dark pixels or, without any, 255, so that nothing has contrast.
int background_level(const cv::Mat& image, const cv::Rect& box, int threshold) {
  const LevelHistogram surroundings = surrounding_levels(image, box);
  if (!surroundings.empty()) return surroundings.median();
  const std::vector<Span> rows = rows_of(box);
  const LevelHistogram inside = levels_in(image, rows.data(), rows.data() + rows.size());
  return inside.count(0, threshold) > 0 ? inside.median(0, threshold) : 255;
}

/// Holds sums over the bright pixels of a piece of a row, with columns counted from its first
/// pixel.
struct RowSums {
  int count{0}, clipped{0}, u{0}, uu{0};
};

constexpr int kPiece_px = 1024;  // sums over pieces of this length fit into 32 bits

RowSums sum_row(const std::uint8_t* row, int width, int least) {
  RowSums sums;
  for (int u = 0; u < width; ++u) {
    const bool lit = row[u] >= least;
    const auto place = static_cast<std::int16_t>(lit ? u : 0);
    sums.count += lit ? 1 : 0;
    sums.clipped += row[u] == 255 ? 1 : 0;
    sums.u += place;
    sums.uu += place * place;
  }
  return sums;
}

/// Sets area, centroid, moments and saturated share from the pixels in the spans that are bright
/// enough.
void sum_up(const cv::Mat& image, const Span* begin, const Span* end, double least_level,
            Blob& blob) {
  const cv::Point origin = blob.box_px.tl();
  const int least = static_cast<int>(std::ceil(least_level));
  double n = 0.0, saturated = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  const auto add = [&](int v, int from, int to) {
    const RowSums row = sum_row(image.ptr<std::uint8_t>(v) + from, to - from, least);
    const double count = row.count, first = row.u, left = from - origin.x, down = v - origin.y;
    const double u = first + left * count, uu = row.uu + left * (2.0 * first + left * count);
    n += count;
    saturated += row.clipped;
    sum += Eigen::Vector2d(u, down * count);
    squares += (Eigen::Matrix2d() << uu, down * u, down * u, down * down * count).finished();
  };
  for (const Span* span = begin; span != end; ++span) {
    for (int u = span->begin; u < span->end; u += kPiece_px)
      add(span->v, u, std::min(u + kPiece_px, span->end));
  }
  const Eigen::Vector2d mean = sum / n;
  blob.uv_px = mean + Eigen::Vector2d(origin.x, origin.y);
  // A pixel is a square of side 1 and has second moments of 1/12 itself.
  blob.second_moments_px2 =
      squares / n - mean * mean.transpose() + Eigen::Matrix2d::Identity() / 12.0;
  blob.area_px2 = n;
  blob.saturated_share = saturated / n;
}

}  // namespace

Span run_round(const cv::Mat& image, int v, int u, int threshold) {
  const auto* row = image.ptr<std::uint8_t>(v);
  Span run{v, u, u + 1};
  while (run.begin > 0 && row[run.begin - 1] > threshold) --run.begin;
  while (run.end < image.cols && row[run.end] > threshold) ++run.end;
  return run;
}

void PatchGrower::start(const cv::Size& image_size) {
  for (const Span& span : spans_)
    std::fill(flags(span.v) + span.begin, flags(span.v) + span.end, 0);
  spans_.clear();
  cols_ = image_size.width;
  taken_.resize(static_cast<std::size_t>(image_size.area()), 0);
}

std::uint8_t* PatchGrower::flags(int v) {
  return taken_.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(cols_);
}

int PatchGrower::take(const Span& span, int layer) {
  std::uint8_t* row = flags(span.v);
  for (int u = span.begin; u < span.end; ++u) row[u] |= static_cast<std::uint8_t>(1 << layer);
  spans_.push_back(span);
  return span.end - span.begin;
}

Patch PatchGrower::grow(const cv::Mat& image, const Span& seed, int threshold, int layer,
                        int most_area_px2) {
  int left = seed.begin, right = seed.end, top = seed.v, bottom = seed.v + 1;
  Patch patch{spans_.size(), 0, {}};
  int area = take(seed, layer);
  for (std::size_t next = patch.first; next < spans_.size() && area <= most_area_px2; ++next) {
    const Span span = spans_[next];
    for (const int v : {span.v - 1, span.v + 1}) {
      if (v < 0 || v >= image.rows) continue;
      const auto* row = image.ptr<std::uint8_t>(v);
      for (int u = span.begin; u < span.end; ++u) {
        if (row[u] <= threshold || is_taken(u, v, layer)) continue;
        const Span grown = run_round(image, v, u, threshold);
        area += take(grown, layer);
        left = std::min(left, grown.begin);
        right = std::max(right, grown.end);
        top = std::min(top, v);
        bottom = std::max(bottom, v + 1);
        u = grown.end;
      }
    }
  }
  patch.last = spans_.size();
  patch.box_px = {left, top, right - left, bottom - top};
  return patch;
}

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
  const std::vector<Span> rows = rows_of(box_px);
  return describe_blob(image, box_px, rows.data(), rows.data() + rows.size(), threshold);
}

Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, const Span* begin, const Span* end,
                   int threshold) {
  Blob blob;
  blob.box_px = box_px;
  blob.level = levels_in(image, begin, end).median(threshold + 1, 255);
  blob.background = background_level(image, box_px, threshold);
  blob.touches_border =
      box_px.x <= 0 || box_px.y <= 0 || box_px.br().x >= image.cols || box_px.br().y >= image.rows;
  sum_up(image, begin, end, 0.5 * (blob.level + blob.background), blob);
  return blob;
}

bool is_filled(const Blob& blob) {
  return blob.contrast() >= kLeastContrast && (blob.touches_border || blob.fill() >= kLeastFill);
}

bool is_lamp_like(const Blob& blob) {
  return is_filled(blob) && (blob.touches_border || blob.axis_ratio() >= kLeastAxisRatio);
}

void require_8_bit(const cv::Mat& image) {
  if (!image.empty() && image.type() != CV_8UC1)
    throw std::invalid_argument("lamps can be detected only in 8-bit images of one channel");
}

}  // namespace planar
