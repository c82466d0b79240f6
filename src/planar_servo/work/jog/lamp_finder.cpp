#include "planar_servo/work/jog/lamp_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/loop/vision/reference_lamps.h"

namespace planar {
namespace {

constexpr int kWhite = 255;
constexpr int kLeastPeak = 128;  // below this, half of the grey levels are unused
/// The share of lit pixels that may be saturated. Lamps are measured by their edges, which clipping
/// at the top leaves alone; a larger share says that the edges are clipped soon.
constexpr double kMostSaturated = 0.02;
constexpr int kHotPixels = 20;
constexpr int kBarWidth = 32;

LevelHistogram levels_of(const cv::Mat& image) {
  LevelHistogram levels;
  for (int row = 0; row < image.rows; ++row)
    levels.add(image.ptr<unsigned char>(row), image.ptr<unsigned char>(row) + image.cols);
  return levels;
}

/// Returns the highest level that more than `n` pixels reach.
int level_reached(const LevelHistogram& levels, int n) {
  int level = kWhite;
  while (level > 0 && levels.count(level, kWhite) <= n) --level;
  return level;
}

/// Returns how wide a lamp's edge is, from a fifth to four fifths of its contrast: as many pixels
/// lie between these levels as the edge is long times its width, the dark round the lamp apart from
/// what else is grey. Unlike the blur of a fitted rim it grows on however far the lens is out of
/// focus.
double edge_width_px(const Frame& frame, const LampPair& pair, std::size_t index) {
  constexpr double kLow = 0.2, kHigh = 0.8;
  const LampCenter& lamp = pair.lamps[index];
  const double between_px = (pair.lamps[1].uv_px - pair.lamps[0].uv_px).norm();
  const double reach_px = std::min(2.0 * lamp.diameter_px, 0.5 * between_px);
  const double corner_u = frame.region_px.x, corner_v = frame.region_px.y;
  const Eigen::Vector2d center(lamp.uv_px.x() - corner_u, lamp.uv_px.y() - corner_v);
  const cv::Rect window =
      window_round(center, reach_px) & cv::Rect(cv::Point(), frame.image.size());
  const double low = lamp.look.background + kLow * lamp.look.contrast();
  const double high = lamp.look.background + kHigh * lamp.look.contrast();
  const cv::Mat around = frame.image(window);
  cv::Mat parts;
  cv::connectedComponents(around > low, parts);
  const cv::Point inside(static_cast<int>(center.x()) - window.x,
                         static_cast<int>(center.y()) - window.y);
  if (!cv::Rect({}, window.size()).contains(inside)) return 0.0;
  const int on_edge = cv::countNonZero((parts == parts.at<int>(inside)) & (around < high));
  return on_edge / (kPi * lamp.diameter_px);
}

}  // namespace

bool ExposureReading::too_dark() const {
  return peak_level < kLeastPeak;
}

bool ExposureReading::too_bright() const {
  return saturated_share > kMostSaturated;
}

std::string ExposureReading::text() const {
  const auto filled = static_cast<std::size_t>(kBarWidth * peak_level / kWhite);
  return fmt::format("[{}{}] peak {} of {}, {:.1f} % of the lit pixels saturated: {}",
                     std::string(filled, '='), std::string(kBarWidth - filled, ' '), peak_level,
                     kWhite, 100.0 * saturated_share,
                     too_bright() ? "too bright, expose less"
                     : too_dark() ? "too dark, expose more"
                                  : "good");
}

ExposureReading read_exposure(const cv::Mat& image) {
  const LevelHistogram levels = levels_of(image);
  ExposureReading reading;
  reading.peak_level = level_reached(levels, kHotPixels);
  const int median = level_reached(levels, static_cast<int>(image.total() / 2));
  const int lit = levels.count((median + reading.peak_level) / 2 + 1, kWhite);
  if (lit > 0) reading.saturated_share = 1.0 * levels.count(kWhite, kWhite) / lit;
  return reading;
}

namespace {

/// Returns the level that half of the counts from `first` on reach; 0 without any.
int median_from(const LevelHistogram& levels, int first, int end) {
  const int all = levels.count(first, end - 1), half = all / 2;
  if (all == 0) return 0;
  int level = first;
  while (level + 1 < end && levels.count(first, level) <= half) ++level;
  return level;
}

std::string bars_of(const LevelHistogram& levels, int pixels) {
  constexpr int kLevelsABar = 16;
  constexpr const char* kBars[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string bars;
  for (int first = 0; first < kWhite; first += kLevelsABar) {
    const int in_bar = levels.count(first, first + kLevelsABar - 1);
    const double height = in_bar == 0 ? 0.0 : 1.0 + 7.0 * std::log(in_bar) / std::log(pixels);
    bars += kBars[static_cast<std::size_t>(height)];
  }
  return bars;
}

}  // namespace

LampLevels read_lamp_levels(const cv::Mat& image) {
  const LevelHistogram levels = levels_of(image);
  const auto pixels = static_cast<int>(image.total());
  const int middle =
      (level_reached(levels, pixels / 2) + level_reached(levels, kHotPixels)) / 2 + 1;
  const auto share = [](int part, int whole) { return whole == 0 ? 0.0 : 1.0 * part / whole; };
  const int around = levels.count(0, middle - 1);
  return {median_from(levels, 0, middle), median_from(levels, middle, kWhite + 1),
          share(levels.count(0, 0), around), share(levels.count(kWhite, kWhite), pixels - around),
          bars_of(levels, pixels)};
}

std::string LampLevels::remedy() const {
  // Above this share the black level is less than the noise's deviation above 0.
  constexpr double kMostDark = 0.16;
  if (dark_share > kMostDark)
    return "raise the camera's BlackLevel by the maker's program: the dark side of rims is cut";
  if (clipped_share > kMostSaturated) return "expose less: camera.exposure_us";
  return lit < kLeastPeak ? "expose more: camera.exposure_us" : "";
}

std::string LampLevels::text() const {
  return fmt::format(
      "levels 0 [{}] 255: ambient {}, lit {}; at 0: {:.0f} % of what is around, at "
      "255: {:.0f} % of the lamp",
      bars, ambient, lit, 100.0 * dark_share, 100.0 * clipped_share);
}

std::optional<SightedLamps> sight_lamps(const Frame& frame,
                                        const std::vector<Eigen::Vector2d>& fixed_px,
                                        const std::optional<LampPixels>& near_px) {
  PairExpectation any;
  any.fixed_px = fixed_px;
  any.predicted_px = near_px;
  const LampPair pair = LampTracker(CenterMethod::kFast).locate(frame, any);
  if (pair.lamps[0].diameter_px <= 0.0 || pair.lamps[1].diameter_px <= 0.0) return std::nullopt;
  return SightedLamps{pair.lamps, {edge_width_px(frame, pair, 0), edge_width_px(frame, pair, 1)}};
}

LampFinder::LampFinder(LampScene scene, CenterMethod method, FrameSource& camera,
                       int follow_region_px)
    : scene_(std::move(scene)),
      method_(method),
      camera_(camera),
      follow_region_px_(follow_region_px) {
  if (scene_.vision) scene_.fixed_px = places_px(scene_.vision->reference_lamps);
}

Frame LampFinder::next_frame(const cv::Rect& region_px) {
  camera_.set_region(region_px);
  FrameResult result = camera_.next_frame();
  if (result.status != FrameStatus::kOk)
    throw WorkError("the camera delivers no frame", Cause::kDevice);
  exposure_ = read_exposure(result.frame.image);
  return std::move(result.frame);
}

std::string LampFinder::find() {
  const PairExpectation expected = LampPrediction(scene_, std::nullopt).of(std::nullopt);
  const LampPair pair = LampTracker(method_).locate(whole_frame(), expected);
  // Two lamps alike cannot be told apart, but their places are known.
  if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous)
    throw WorkError({fmt::format("no two lamps in the whole frame: {}", name(pair.status)),
                     "save the frame and look at it (command save)", "", Cause::kInsufficient});
  const auto& [first, second] = pair.lamps;
  middle_px_ = 0.5 * (first.uv_px + second.uv_px);
  std::string text = fmt::format(
      "{} at ({}) and ({}) px, {:.1f} and {:.1f} px wide",
      first.status == LampStatus::kAmbiguous ? "more than two lights, the most evident" : "lamps",
      fixed(first.uv_px, 1, ", "), fixed(second.uv_px, 1, ", "), first.diameter_px,
      second.diameter_px);
  if (!scene_.vision) return text;
  const Workplane& plane = scene_.vision->workplane;
  const auto first_B = plane.plane_from_pixel(first.uv_px);
  const auto second_B = plane.plane_from_pixel(second.uv_px);
  if (!first_B || !second_B) return text;
  return text + fmt::format("\non the plane at {} and {}, uncompensated", place_mm(*first_B),
                            place_mm(*second_B));
}

std::optional<SightedLamps> LampFinder::sight(const cv::Rect& region_px) {
  auto sight = sight_lamps(next_frame(region_px), scene_.fixed_px);
  middle_px_.reset();
  if (sight) middle_px_ = 0.5 * (sight->lamps[0].uv_px + sight->lamps[1].uv_px);
  return sight;
}

std::string LampFinder::focus() {
  const cv::Size sensor_px = camera_.sensor_size_px();
  std::optional<SightedLamps> seen;
  if (middle_px_) seen = sight(follow_region(sensor_px, follow_region_px_, *middle_px_));
  if (!seen) seen = sight({{}, sensor_px});
  if (!seen)
    throw WorkError({"no two lamps in the whole frame", "turn the lens, or expose more", "",
                     Cause::kInsufficient});
  const auto [first_px, second_px] = seen->edges_px;
  const double mean_px = seen->mean_edge_px();
  best_px_ = std::min(mean_px, best_px_.value_or(mean_px));
  return fmt::format(
      "edges {:.2f} px wide ({:.2f}, {:.2f}), best {:.2f}; peak {}, {:.1f} % saturated", mean_px,
      first_px, second_px, *best_px_, exposure_->peak_level, 100.0 * exposure_->saturated_share);
}

}  // namespace planar
