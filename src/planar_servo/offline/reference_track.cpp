#include "planar_servo/offline/reference_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

/// The most whole frames in which a light must be seen to stand still.
constexpr std::size_t kStillFrames = 12;
/// The most lights of a whole frame that are considered.
constexpr std::size_t kMostLights = 64;

/// Returns the images of the whole sensor that may show the lamps, by time.
std::vector<const LampImage*> whole_frames(const std::vector<LampImage>& images,
                                           const cv::Size& sensor_px) {
  std::vector<const LampImage*> whole;
  for (const LampImage& image : images)
    if (!image.shows_board && image.t_s && image.region_px && image.region_px->size() == sensor_px)
      whole.push_back(&image);
  std::stable_sort(whole.begin(), whole.end(),
                   [](const LampImage* a, const LampImage* b) { return *a->t_s < *b->t_s; });
  return whole;
}

Frame frame_of(const LampImage& image, const cv::Size& sensor_px) {
  LampImageRead read = read_lamp_image(image, sensor_px);
  if (read.status != LampStatus::kOk)
    throw WorkError(
        {name(read.status), "a whole frame is needed to find the reference lamps", image.file});
  return std::move(read.frame);
}

std::vector<LampCenter> lights_in(const cv::Mat& image, LampDetector& detector,
                                  CenterMethod method) {
  const std::vector<Blob>& blobs = detector.detect(image);
  std::vector<LampCenter> lights;
  for (std::size_t i = 0; i < std::min(blobs.size(), kMostLights); ++i) {
    const LampCenter light = measure_lamp(image, blobs[i], method);
    if (light.status == LampStatus::kOk) lights.push_back(light);
  }
  return lights;
}

/// Returns whether a light stands within half its diameter of where it stood.
bool stands(const LampCenter& light, const Frame& frame, LampDetector& detector,
            CenterMethod method) {
  const auto seen = find_fixed_light(frame, light.uv_px, detector, method);
  return seen && (seen->uv_px - light.uv_px).norm() < 0.5 * light.diameter_px;
}

}  // namespace

ReferenceTrack::ReferenceTrack(std::vector<ReferenceLamp> lamps,
                               const std::vector<LampImage>& images, const cv::Size& sensor_px,
                               CenterMethod method)
    : lamps_(std::move(lamps)) {
  ReferenceWatch watch(lamps_, method);
  for (const LampImage* image : whole_frames(images, sensor_px)) {
    watch.look(frame_of(*image, sensor_px));
    if (watch.objection()) throw WorkError(watch.objection()->at(image->file));
    looks_.push_back({*image->t_s, watch.motion()});
  }
}

ImageMotion ReferenceTrack::at(double t_s) const {
  if (looks_.empty()) return {};
  const auto next =
      std::find_if(looks_.begin(), looks_.end(), [&](const Look& look) { return look.t_s >= t_s; });
  if (next == looks_.end()) return looks_.back().motion;
  if (next == looks_.begin()) return next->motion;
  const Look& last = *(next - 1);
  return last.motion.towards(next->motion, (t_s - last.t_s) / (next->t_s - last.t_s));
}

std::vector<ReferenceLamp> find_reference_lamps(const std::vector<ReferenceLampLayout>& layout,
                                                const std::vector<LampImage>& images,
                                                const cv::Size& sensor_px, CenterMethod method) {
  const std::vector<const LampImage*> whole = whole_frames(images, sensor_px);
  if (whole.size() < 2)
    throw WorkError(
        {fmt::format("{} whole frames show the lamps", whole.size()),
         fmt::format("at least 2 at different places are needed to tell the {} reference lamps of "
                     "the cell file from those of the tool: record with planar-record",
                     layout.size())});
  LampDetector detector;
  std::vector<LampCenter> lights =
      lights_in(frame_of(*whole[0], sensor_px).image, detector, method);
  const std::size_t n = std::min(whole.size() - 1, kStillFrames);
  for (std::size_t i = 1; i <= n; ++i) {
    const Frame frame = frame_of(*whole[i * (whole.size() - 1) / n], sensor_px);
    lights.erase(std::remove_if(lights.begin(), lights.end(),
                                [&](const LampCenter& light) {
                                  return !stands(light, frame, detector, method);
                                }),
                 lights.end());
  }
  if (lights.size() < layout.size())
    throw WorkError(
        {fmt::format(
             "{} lights stand still in {} whole frames, but the cell file names {} reference lamps",
             lights.size(), n + 1, layout.size()),
         "uncover them, or name those that there are"});
  lights.resize(layout.size());
  std::vector<ReferenceLamp> lamps;
  lamps.reserve(lights.size());
  for (const LampCenter& light : lights)
    lamps.push_back({"", light.uv_px, std::sqrt(0.5 * light.covariance_px2.trace())});
  return lamps;
}

void name_reference_lamps(const std::vector<ReferenceLampLayout>& layout, const BaseView& view,
                          std::vector<ReferenceLamp>& lamps) {
  std::sort(lamps.begin(), lamps.end(), [](const ReferenceLamp& a, const ReferenceLamp& b) {
    return std::pair(a.uv_px.y(), a.uv_px.x()) < std::pair(b.uv_px.y(), b.uv_px.x());
  });
  std::vector<Eigen::Vector2d> stated;
  for (const ReferenceLampLayout& lamp : layout) {
    const auto place = lamp.p_B ? view(*lamp.p_B) : std::nullopt;
    if (place) stated.push_back(*place);
  }
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (stated.size() == layout.size())
      std::iter_swap(lamps.begin() + static_cast<std::ptrdiff_t>(i),
                     std::min_element(lamps.begin() + static_cast<std::ptrdiff_t>(i), lamps.end(),
                                      [&](const ReferenceLamp& a, const ReferenceLamp& b) {
                                        return (a.uv_px - stated[i]).squaredNorm() <
                                               (b.uv_px - stated[i]).squaredNorm();
                                      }));
    lamps[i].id = layout[i].id;
  }
}

}  // namespace planar
