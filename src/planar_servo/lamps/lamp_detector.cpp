#include "planar_servo/lamps/lamp_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr int kLeastLamp_px = 12;
constexpr int kLeastExtent_px = 10;  // of that lamp above half its level, with room for noise
constexpr double kLeastArea_px2 = 0.25 * kPi * kLeastExtent_px * kLeastExtent_px;
constexpr int kMostArea_px2 = 512 * 512;

// With this step one row passes within 4 px of the centre. A lamp of 12 px has a chord of 8.9 px
// there, of which a ragged rim may take some.
constexpr int kRowStep = 8;
constexpr int kLeastRun_px = 6;

// Several rows are read in parallel, some pixels of each in turn, which is nearly twice as fast as
// row after row.
constexpr int kRowsAtOnce = 8, kBlock_px = 256;

constexpr int kTile_px = 256;  // side of a tile, whose levels are learned together
constexpr int kSampledRows = 4, kSampledColumns = 32;  // at least, of a tile
constexpr int kMostColumnStep = 16;
constexpr double kNoiseFactor = 6.0;  // in standard deviations of the background
constexpr int kLeastStep = 10;        // in grey levels above the background
constexpr double kBrightest = 255.0;

constexpr int kThresholds = 4;           // tried on a patch, each higher than the one before
constexpr int kMostDiscs = 4;            // looked for in one patch
constexpr double kDiscReach = 1.25;      // radius of a disc's pixels, in its own radii
constexpr double kMostRingShare = 0.25;  // of the ring round a disc that may be bright

/// Returns the level above which a pixel may belong to a lamp: well above the background's noise
/// or, without an even background, between the two classes of levels.
int threshold_for(const LevelHistogram& levels) {
  const int background = levels.median();
  const double sigma = kNormalPerMad * levels.median_deviation(background);
  const double threshold = background + std::max<double>(kNoiseFactor * sigma, kLeastStep);
  if (threshold < 0.5 * (background + kBrightest)) return static_cast<int>(std::lround(threshold));
  return levels.otsu();
}

std::uint8_t brightest(const std::uint8_t* row, const Span& span) {
  std::uint8_t most = 0;
  for (int u = span.begin; u < span.end; ++u) most = std::max(most, row[u]);
  return most;
}

int brightest(const cv::Mat& image, const Span* begin, const Span* end) {
  std::uint8_t most = 0;
  for (const Span* span = begin; span != end; ++span)
    most = std::max(most, brightest(image.ptr<std::uint8_t>(span->v), *span));
  return most;
}

/// Returns the first probe at or after `u`. Probes are kLeastRun_px apart, so that every run of
/// that length holds one.
int next_probe(int u) {
  return (u + kLeastRun_px - 1) / kLeastRun_px * kLeastRun_px;
}

/// Returns whether bright pixels reach as far above and below a run as in the smallest lamp. It
/// tries three columns of the run, because a scratch may cross one.
bool is_tall(const cv::Mat& image, const Span& run, int threshold) {
  constexpr int kHalf = kLeastExtent_px / 2;
  for (const int quarter : {2, 1, 3}) {
    const int u = run.begin + quarter * (run.end - run.begin) / 4;
    const auto is_bright = [&](int v) {
      return v < 0 || v >= image.rows || image.at<std::uint8_t>(v, u) > threshold;
    };
    if (!is_bright(run.v - kHalf) && !is_bright(run.v + kHalf)) continue;
    int top = run.v, bottom = run.v + 1;
    const auto grown = [&] { return bottom - top >= kLeastExtent_px; };
    while (!grown() && is_bright(top - 1)) --top;
    while (!grown() && is_bright(bottom)) ++bottom;
    if (grown()) return true;
  }
  return false;
}

bool is_large_enough(const Blob& blob) {
  return blob.area_px2 >= kLeastArea_px2;
}

double ring_share(const cv::Mat& mask, const cv::Point& center, double radius_px) {
  constexpr int kPoints = 48;
  int set = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * kPi * i / kPoints;
    const cv::Point p(static_cast<int>(std::lround(center.x + radius_px * std::cos(angle))),
                      static_cast<int>(std::lround(center.y + radius_px * std::sin(angle))));
    if (p.inside({0, 0, mask.cols, mask.rows}) && mask.at<std::uint8_t>(p) != 0) ++set;
  }
  return static_cast<double>(set) / kPoints;
}

double evidence(const Blob& blob) {
  return blob.diameter_px() * blob.contrast();
}

/// Returns the length of pieces of about `piece` whose inner borders are multiples of `step`.
int piece_length(int length, int piece, int step) {
  const int pieces = std::max(1, length / piece);
  return (length + pieces * step - 1) / (pieces * step) * step;
}

}  // namespace

const std::vector<Blob>& LampDetector::detect(const cv::Mat& image) {
  return detect(image, {{0, 0}, image.size()});
}

const std::vector<Blob>& LampDetector::detect(const cv::Mat& image, const cv::Rect& window_px) {
  require_8_bit(image);
  found_.clear();
  const cv::Rect window = window_px & cv::Rect({0, 0}, image.size());
  if (std::min(window.width, window.height) < kLeastLamp_px) return found_;
  patches_.start(image.size());
  const int height = piece_length(window.height, kTile_px, kRowStep * kRowsAtOnce);
  for (int v = window.y; v < window.br().y; v += height)
    search_band(image, cv::Rect(window.x, v, window.width, height) & window);
  std::sort(found_.begin(), found_.end(),
            [](const Blob& a, const Blob& b) { return evidence(a) > evidence(b); });
  return found_;
}

/// Learns the threshold of each of the band's tiles, which stand side by side, from some pixels of
/// the rows that are searched.
void LampDetector::learn_thresholds(const cv::Mat& image, const cv::Rect& band, int tile_width) {
  tiles_.assign(static_cast<std::size_t>((band.width + tile_width - 1) / tile_width), {});
  const int row_step = kRowStep * std::max(1, band.height / (kRowStep * kSampledRows));
  const int column_step = std::clamp(band.width / kSampledColumns, 1, kMostColumnStep);
  for (int block = 0; block < band.width; block += kBlock_px) {
    LevelHistogram& levels = tiles_[static_cast<std::size_t>(block / tile_width)];
    const int end = std::min(block + kBlock_px, band.width);
    for (int v = std::min(kRowStep / 2, band.height - 1); v < band.height; v += row_step) {
      const auto* row = image.ptr<std::uint8_t>(band.y + v) + band.x;
      for (int u = block; u < end; u += column_step) levels.add(row[u]);
    }
  }
  thresholds_.clear();
  for (const LevelHistogram& tile : tiles_) thresholds_.push_back(threshold_for(tile));
}

void LampDetector::search_band(const cv::Mat& image, const cv::Rect& band) {
  const int width = piece_length(band.width, kTile_px, kBlock_px);
  learn_thresholds(image, band, width);
  for (int first = kRowStep / 2; first < band.height; first += kRowStep * kRowsAtOnce) {
    const int last = std::min(first + kRowStep * kRowsAtOnce, band.height);
    for (int u = 0; u < band.width; u += kBlock_px) {
      const int threshold = thresholds_[static_cast<std::size_t>(u / width)];
      const int end = std::min(u + kBlock_px, band.width);
      for (int v = first; v < last; v += kRowStep) {
        const Span block{band.y + v, band.x + u, band.x + end};
        if (brightest(image.ptr<std::uint8_t>(block.v), block) > threshold)
          search_block(image, block, threshold, 0);
      }
    }
  }
}

/// Adds the lamps in patches that cross the block; returns whether there is one.
bool LampDetector::search_block(const cv::Mat& image, const Span& block, int threshold, int layer) {
  const auto* row = image.ptr<std::uint8_t>(block.v);
  bool any = false;
  for (int u = next_probe(block.begin); u < block.end;) {
    if (row[u] <= threshold) {
      u += kLeastRun_px;
      continue;
    }
    const Span run = run_round(image, block.v, u, threshold);
    any |= examine(image, run, threshold, layer);
    u = next_probe(run.end);
  }
  return any;
}

/// Adds the lamps in the patch round a run; returns whether there is one.
bool LampDetector::examine(const cv::Mat& image, const Span& run, int threshold, int layer) {
  if (run.end - run.begin < kLeastRun_px || !is_tall(image, run, threshold) ||
      patches_.is_taken(run.begin, run.v, layer))
    return false;
  const Patch patch = patches_.grow(image, run, threshold, layer, kMostArea_px2);
  const Blob blob =
      describe_blob(image, patch.box_px, patches_.begin(patch), patches_.end(patch), threshold);
  if (!is_large_enough(blob)) return false;
  if (is_lamp_like(blob)) {
    found_.push_back(blob);
    return true;
  }
  const int most = brightest(image, patches_.begin(patch), patches_.end(patch));
  if (most > blob.level + kLeastContrast &&
      take_apart(image, patch, (threshold + most) / 2, layer + 1))
    return true;
  return !is_filled(blob) && find_discs(image, patch, threshold);
}

/// Adds the lamps that stand out of the patch above a higher threshold; returns whether there is
/// one.
bool LampDetector::take_apart(const cv::Mat& image, const Patch& patch, int threshold, int layer) {
  if (layer == kThresholds) return false;
  bool any = false;
  for (std::size_t i = patch.first; i < patch.last; ++i) {
    const Span span = patches_.span(i);
    if (span.v % (kRowStep / 2) != 0) continue;
    any |= search_block(image, span, threshold, layer);
  }
  return any;
}

/// Adds the round lamps of a patch in which other lights touch them: the largest discs that fit
/// into it and have mostly dark surroundings. Returns whether there is one.
bool LampDetector::find_discs(const cv::Mat& image, const Patch& patch, int threshold) {
  const cv::Rect& box = patch.box_px;
  mask_.create(box.height + 2, box.width + 2, CV_8UC1);
  mask_.setTo(0);
  const cv::Point origin = box.tl() - cv::Point(1, 1);
  for (const Span* span = patches_.begin(patch); span != patches_.end(patch); ++span) {
    auto* row = mask_.ptr<std::uint8_t>(span->v - origin.y);
    std::fill(row + span->begin - origin.x, row + span->end - origin.x, std::uint8_t{255});
  }
  cv::distanceTransform(mask_, depth_, cv::DIST_L2, cv::DIST_MASK_5);
  bool any = false;
  for (int i = 0; i < kMostDiscs; ++i) {
    double radius_px = 0.0;
    cv::Point center;
    cv::minMaxLoc(depth_, nullptr, &radius_px, nullptr, &center);
    if (2.0 * radius_px < kLeastExtent_px) return any;
    const double reach_px = kDiscReach * radius_px + 1.0;
    cv::circle(depth_, center, static_cast<int>(reach_px), cv::Scalar(0.0), cv::FILLED);
    if (ring_share(mask_, center, reach_px + 1.0) > kMostRingShare) continue;
    any |= add_disc(image, patch, center + origin, reach_px, threshold);
  }
  return any;
}

/// Adds the lamp that the patch's pixels round `center` form, if they do; returns whether they do.
bool LampDetector::add_disc(const cv::Mat& image, const Patch& patch, const cv::Point& center,
                            double reach_px, int threshold) {
  disc_.clear();
  cv::Rect box;
  for (const Span* span = patches_.begin(patch); span != patches_.end(patch); ++span) {
    const double dv = span->v - center.y;
    if (std::abs(dv) > reach_px) continue;
    const int half = static_cast<int>(std::sqrt(reach_px * reach_px - dv * dv));
    const Span part{span->v, std::max(span->begin, center.x - half),
                    std::min(span->end, center.x + half + 1)};
    if (part.begin >= part.end) continue;
    disc_.push_back(part);
    const cv::Rect row(part.begin, part.v, part.end - part.begin, 1);
    box = box.empty() ? row : box | row;
  }
  const Blob blob = describe_blob(image, box, disc_.data(), disc_.data() + disc_.size(), threshold);
  if (!is_large_enough(blob) || !is_lamp_like(blob)) return false;
  found_.push_back(blob);
  return true;
}

}  // namespace planar
