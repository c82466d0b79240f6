#include "planar_servo/lamps/detect/bright_patch.h"

#include <algorithm>

namespace planar {

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

}  // namespace planar
