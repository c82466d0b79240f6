#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace planar {

/// Counts grey levels. Its statistics are 0 when it is empty.
class LevelHistogram {
 public:
  void add(std::uint8_t level) {
    ++counts_[level];
    ++total_;
  }
  void add(const std::uint8_t* begin, const std::uint8_t* end) {
    for (const std::uint8_t* level = begin; level != end; ++level) ++counts_[*level];
    total_ += static_cast<int>(end - begin);
  }
  bool empty() const { return total_ == 0; }
  int median() const;
  /// Returns the median of the counts from `lowest` to `highest`, both included.
  int median(int lowest, int highest) const;
  int count(int lowest, int highest) const;
  /// Returns the median distance of the counts from a level.
  int median_deviation(int level) const;
  /// Returns the highest level of the lower of two classes of levels that are as far apart as
  /// possible [Otsu 1979].
  int otsu() const;

 private:
  static constexpr int kLevels = 256;

  std::array<int, kLevels> counts_{};
  int total_{0};
};

/// The pixels begin <= u < end of row v.
struct Span {
  int v{0}, begin{0}, end{0};
};

/// Returns the run of pixels above the threshold around pixel (u, v).
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

/// A bright patch, to the whole pixel. Detection and vpDot2 produce it; the measurement of a centre
/// starts from it. Pixel coordinates of the image; grey levels 0 to 255.
struct Blob {
  Eigen::Vector2d uv_px{0.0, 0.0};                              ///< centroid
  Eigen::Matrix2d second_moments_px2{Eigen::Matrix2d::Zero()};  ///< central, per unit of area
  double area_px2{0.0};
  cv::Rect box_px;
  double level{0.0};            ///< median of its pixels
  double background{0.0};       ///< median of the pixels round its box
  double saturated_share{0.0};  ///< share of its pixels at 255
  bool touches_border{false};   ///< its box reaches the edge of the image

  double contrast() const { return level - background; }
  /// Returns the diameter of the disc of the same area.
  double diameter_px() const;
  /// Returns the ratio of minor to major axis of the ellipse with the same second moments.
  double axis_ratio() const;
  /// Returns the area divided by that of this ellipse: 1 for a full ellipse, less for other shapes.
  double fill() const;
};

/// Describes the blob inside `box_px`: the pixels above the midpoint between the background and the
/// median level of those above `threshold`. The box must lie in the image and hold such a pixel.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, int threshold);

/// Describes the blob that the spans form inside `box_px`; other pixels of the box are left out.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, const Span* begin, const Span* end,
                   int threshold);

/// The least contrast of a lamp, in grey levels. Dimmer patches cannot be told from clutter.
constexpr double kLeastContrast = 20.0;

/// Returns whether the patch has enough contrast and is full. A patch cut by the image's edge
/// passes, because its shape is unknown.
bool is_filled(const Blob& blob);

/// Returns whether the blob is full and as round as a disc that is not seen from the side.
bool is_lamp_like(const Blob& blob);

/// Throws std::invalid_argument unless the image is CV_8UC1.
void require_8_bit(const cv::Mat& image);

}  // namespace planar
