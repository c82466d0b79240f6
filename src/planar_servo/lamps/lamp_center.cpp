#include "planar_servo/lamps/lamp_center.h"

#include <visp3/blob/vpDot2.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/paper_center.h"
#include "planar_servo/lamps/rim/outline.h"
#include "planar_servo/lamps/rim/rim_band.h"
#include "planar_servo/lamps/rim/rim_fit.h"

namespace planar {
namespace {

constexpr int kLeastSide_px = 3;  // of a window, and of a blob
// Half the side of the patch over the blob's size. vpDot2 searches a square of 5 times its size.
constexpr double kDotReach = 3.0;

vpImage<unsigned char> visp_image(const cv::Mat& patch) {
  vpImage<unsigned char> image(static_cast<unsigned>(patch.rows),
                               static_cast<unsigned>(patch.cols));
  for (int v = 0; v < patch.rows; ++v)
    std::copy_n(patch.ptr<std::uint8_t>(v), patch.cols, image[static_cast<unsigned>(v)]);
  return image;
}

int level_between(const Blob& blob) {
  return std::clamp(static_cast<int>(std::lround(0.5 * (blob.level + blob.background))), 1, 255);
}

int size_of(const Blob& blob) {
  return std::max(blob.box_px.width, blob.box_px.height);
}

/// Returns what vpDot2 sees in the window of the image. Empty when that is too small for a blob.
std::optional<VpDot> seen_by(const vpDot2& dot, const cv::Mat& image, const cv::Rect& window,
                             int level) {
  const vpRect bounds = dot.getBBox();
  const cv::Rect box(window.x + static_cast<int>(bounds.getLeft()),
                     window.y + static_cast<int>(bounds.getTop()),
                     static_cast<int>(bounds.getWidth()), static_cast<int>(bounds.getHeight()));
  const cv::Rect box_in_window = box & window;
  if (std::min(box_in_window.width, box_in_window.height) < kLeastSide_px) return std::nullopt;
  return VpDot{{window.x + dot.getCog().get_u(), window.y + dot.getCog().get_v()},
               describe_blob(image, box_in_window, level - 1)};
}

}  // namespace

VpDotTracker::VpDotTracker() = default;
VpDotTracker::VpDotTracker(VpDotTracker&&) noexcept = default;
VpDotTracker& VpDotTracker::operator=(VpDotTracker&&) noexcept = default;
VpDotTracker::~VpDotTracker() = default;

std::optional<VpDot> VpDotTracker::start(const cv::Mat& image, const Eigen::Vector2d& corner_px,
                                         const Blob& blob) {
  dot_ = std::make_unique<vpDot2>();
  dot_->setEllipsoidShapePrecision(0.0);  // the shape is judged by is_lamp_like()
  place_px_ = blob.uv_px + corner_px;
  level_ = level_between(blob);
  size_px_ = size_of(blob);
  return look(image, corner_px, 1.0, [&](const vpImage<unsigned char>& patch, vpImagePoint place) {
    place.set_uv(std::round(place.get_u()), std::round(place.get_v()));
    dot_->initTracking(patch, place, static_cast<unsigned>(level_), 255u);
  });
}

std::optional<VpDot> VpDotTracker::track(const cv::Mat& image, const Eigen::Vector2d& corner_px) {
  if (!dot_) return std::nullopt;
  return look(image, corner_px, kDotReach,
              [&](const vpImage<unsigned char>& patch, vpImagePoint place) {
                // vpDot2 would take levels about the blob's mean instead.
                dot_->setGrayLevelMin(static_cast<unsigned>(level_));
                dot_->setGrayLevelMax(255u);
                dot_->setCog(place);
                dot_->track(patch);
              });
}

template <typename Action>
std::optional<VpDot> VpDotTracker::look(const cv::Mat& image, const Eigen::Vector2d& corner_px,
                                        double reach, const Action& action) {
  const Eigen::Vector2d place = place_px_ - corner_px;
  const cv::Rect window = window_round(place, reach * size_px_) & cv::Rect({0, 0}, image.size());
  std::optional<VpDot> seen;
  if (std::min(window.width, window.height) >= kLeastSide_px &&
      window.contains(
          {static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y()))})) {
    try {
      action(visp_image(image(window)), {place.y() - window.y, place.x() - window.x});
      seen = seen_by(*dot_, image, window, level_);
    } catch (const vpException&) {  // how vpDot2 says that there is no blob
    }
  }
  if (!seen) {
    forget();
    return std::nullopt;
  }
  place_px_ = seen->center_px + corner_px;
  level_ = level_between(seen->blob);
  size_px_ = size_of(seen->blob);
  return seen;
}

void VpDotTracker::forget() {
  dot_.reset();
}

cv::Rect window_round(const Eigen::Vector2d& uv_px, double half_side_px) {
  const int half = static_cast<int>(std::ceil(half_side_px));
  return {static_cast<int>(std::lround(uv_px.x())) - half,
          static_cast<int>(std::lround(uv_px.y())) - half, 2 * half + 1, 2 * half + 1};
}

namespace {

struct LightSums {
  int light{0}, first{0};  ///< light, and light times column
  int rim{0};              ///< pixels whose light is neither 0 nor full
};

LightSums sum_row(const std::uint8_t* row, int width, std::int16_t lowest, std::int16_t full) {
  constexpr std::int16_t kNone = 0;
  LightSums sums;
  for (int u = 0; u < width; ++u) {
    const auto above = static_cast<std::int16_t>(row[u] - lowest);
    const std::int16_t light = std::min(std::max(above, kNone), full);
    const auto is_rim = static_cast<std::int16_t>((light > kNone) & (light < full));
    sums.light += light;
    sums.first += static_cast<std::int16_t>(u) * light;
    sums.rim += is_rim;
  }
  return sums;
}

/// Measures the centre of gravity of a blob's light. Light counts from 20 % to 80 % of the
/// contrast, so that noise inside and outside does not move it. It is exact for an evenly bright
/// disc on a dark ground and biased by all other light. The covariance is that of the noise of the
/// rim's pixels.
LampCenter by_light(const cv::Mat& image, const Blob& blob, LampCenter lamp) {
  constexpr double kLowest = 0.2, kHighest = 0.8;
  constexpr int kMargin_px = 2;
  const auto level = [&](double share) {
    return static_cast<std::int16_t>(std::lround(blob.background + share * blob.contrast()));
  };
  const std::int16_t lowest = level(kLowest);
  const auto full = static_cast<std::int16_t>(level(kHighest) - lowest);
  if (full <= 0) return lamp;
  const cv::Rect box =
      (blob.box_px + cv::Size(2 * kMargin_px, 2 * kMargin_px) - cv::Point(kMargin_px, kMargin_px)) &
      cv::Rect({0, 0}, image.size());
  double light = 0.0, rim = 0.0;
  Eigen::Vector2d first(0.0, 0.0);
  for (int v = 0; v < box.height; ++v) {
    const LightSums row =
        sum_row(image.ptr<std::uint8_t>(box.y + v) + box.x, box.width, lowest, full);
    light += row.light;
    first += Eigen::Vector2d(row.first, v * row.light);
    rim += row.rim;
  }
  if (light <= 0.0) return lamp;
  const PixelNoise noise = estimate_noise(image, outline_of(blob));
  const double variance = noise.variance(0.5 * (blob.level + blob.background));
  // An ellipse's rim has twice the second moments of its area.
  const Eigen::Vector2d lever = 2.0 * rim * blob.second_moments_px2.diagonal();
  lamp.status = LampStatus::kOk;
  lamp.uv_px = first / light + Eigen::Vector2d(box.x, box.y);
  lamp.covariance_px2 = (variance / (light * light) * lever).asDiagonal();
  return lamp;
}

constexpr double kMostSaturated = 0.5;  // share of the lamp's pixels
constexpr double kLargestGap = 100.0 * kDegree;

/// vpDot2's edges are whole pixels: uniform over one pixel, one per pixel of the rim.
LampCenter at_dot(const VpDot& dot, LampCenter lamp) {
  lamp.status = LampStatus::kOk;
  lamp.uv_px = dot.center_px;
  lamp.covariance_px2 = Eigen::Matrix2d::Identity() / (12.0 * kPi * 0.5 * dot.blob.diameter_px());
  return lamp;
}

LampCenter by_vp_dot(const cv::Mat& image, const Blob& blob, const LampCenter& lamp) {
  const std::optional<VpDot> dot = VpDotTracker().start(image, {0.0, 0.0}, blob);
  return dot ? at_dot(*dot, lamp) : lamp;
}

LampCenter by_kasa(const cv::Mat& image, const Blob& blob, LampCenter lamp) {
  constexpr double kParameters = 3.0;
  constexpr double kSpacing_px = 1.11;  // mean length of a step to a neighbour in 8 directions
  const std::vector<Eigen::Vector2d> edges = canny_edges(image, blob);
  const std::optional<Circle> circle = kasa_circle(edges);
  if (!circle) return lamp;
  double sum = 0.0;
  std::vector<EdgeResidual> residuals;
  for (const Eigen::Vector2d& p : edges) {
    const Eigen::Vector2d d = p - circle->center;
    residuals.push_back({std::atan2(d.y(), d.x()), d.norm() - circle->radius});
    sum += residuals.back().distance * residuals.back().distance;
  }
  // So far apart along the rim, in edges, two windows still share pixels.
  const auto reach = std::lround(2.0 * moments_for(blob).radius_px() / kSpacing_px);
  const double shared = edges_per_independent(residuals, static_cast<int>(reach));
  const double independent = static_cast<double>(edges.size()) / shared;
  if (independent <= kParameters) return lamp;
  const double variance = sum / shared / (independent - kParameters);
  lamp.status = LampStatus::kOk;
  lamp.uv_px = circle->center;
  lamp.covariance_px2 = 2.0 * variance / independent * Eigen::Matrix2d::Identity();
  lamp.diameter_px = 2.0 * circle->radius;
  return lamp;
}

LampCenter by_rim(const cv::Mat& image, const Blob& blob, double reach_px, LampCenter lamp) {
  const std::optional<RimFit> rim = fit_rim(image, blob, reach_px);
  if (!rim || rim->largest_gap > kLargestGap) {
    if (blob.saturated_share > kMostSaturated) lamp.status = LampStatus::kSaturated;
    return lamp;
  }
  lamp.status = LampStatus::kOk;
  lamp.uv_px = rim->center;
  lamp.covariance_px2 = rim->center_covariance;
  lamp.diameter_px = rim->diameter;
  lamp.look.blur_px = rim->blur_px;
  return lamp;
}

/// Returns how many pixels lie between a box and the nearest edge of the image.
int margin_px(const cv::Size& image, const cv::Rect& box) {
  return std::min({box.x, box.y, image.width - box.br().x, image.height - box.br().y});
}

/// Returns the lamp before it is measured: kNotRound unless it cannot be measured at all.
LampCenter unmeasured(const cv::Mat& image, const Blob& blob) {
  LampCenter lamp;
  lamp.uv_px = blob.uv_px;
  lamp.diameter_px = blob.diameter_px();
  lamp.look = {blob.level, blob.background, 0.0, blob.axis_ratio()};
  lamp.status = LampStatus::kNotRound;
  if (margin_px(image.size(), blob.box_px) < least_margin_px(moments_for(blob))) {
    lamp.status = LampStatus::kAtBorder;
  } else if (blob.contrast() <= 0.0) {
    lamp.status = LampStatus::kLowContrast;
  }
  return lamp;
}

}  // namespace

LampCenter measure_lamp(const cv::Mat& image, const Blob& blob, CenterMethod method) {
  require_8_bit(image);
  LampCenter lamp = unmeasured(image, blob);
  if (lamp.status != LampStatus::kNotRound) return lamp;
  switch (method) {
    case CenterMethod::kAuto:
      return by_rim(image, blob, margin_px(image.size(), blob.box_px), lamp);
    case CenterMethod::kFast:
      return by_light(image, blob, lamp);
    case CenterMethod::kVpDot2:
      return by_vp_dot(image, blob, lamp);
    case CenterMethod::kCannyKasa:
      break;
  }
  if (blob.saturated_share > kMostSaturated) {
    lamp.status = LampStatus::kSaturated;
    return lamp;
  }
  return by_kasa(image, blob, lamp);
}

LampCenter lamp_at_dot(const cv::Mat& image, const VpDot& dot) {
  const LampCenter lamp = unmeasured(image, dot.blob);
  return lamp.status == LampStatus::kNotRound ? at_dot(dot, lamp) : lamp;
}

}  // namespace planar
