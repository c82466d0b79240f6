#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace planar {

/// The pixels begin <= u < end of row v.
struct Span {
  int v{0}, begin{0}, end{0};
};

/// Returns the run of pixels above the threshold round pixel (u, v).
Span run_round(const cv::Mat& image, int v, int u, int threshold);

/// A patch: a range of the spans of a PatchGrower.
struct Patch {
  std::size_t first{0}, last{0};  ///< last is one beyond the end
  cv::Rect box_px;
};

/// Grows 4-connected patches of bright pixels. There are 8 layers, for patches above different
/// thresholds; in each a pixel belongs to one patch only. It keeps its memory from image to image.
class PatchGrower {
 public:
  /// Forgets all patches.
  void start(const cv::Size& image_size);

  bool is_taken(int u, int v, int layer) const {
    const std::size_t index =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(cols_) + static_cast<std::size_t>(u);
    return (taken_[index] >> layer & 1) != 0;
  }

  /// Grows the patch above the threshold round `seed`. Stops beyond `most_area_px2`.
  Patch grow(const cv::Mat& image, const Span& seed, int threshold, int layer, int most_area_px2);

  Span span(std::size_t index) const { return spans_[index]; }

  /// These spans are valid until another patch is grown.
  const Span* begin(const Patch& patch) const { return spans_.data() + patch.first; }
  const Span* end(const Patch& patch) const { return spans_.data() + patch.last; }

 private:
  std::uint8_t* flags(int v);
  int take(const Span& span, int layer);

  int cols_{0};
  std::vector<std::uint8_t> taken_;  ///< a bit per layer; zero where no span lies
  std::vector<Span> spans_;
};

}  // namespace planar
