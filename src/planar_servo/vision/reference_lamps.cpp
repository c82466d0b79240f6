#include "planar_servo/vision/reference_lamps.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

/// Half the side of the window that is searched for a lamp: two diameters of a lamp of 30 px. The
/// window follows the camera from look to look.
constexpr int kHalfWindow_px = 64;
/// With fewer, a knocked lamp cannot be told from a camera that moved.
constexpr std::size_t kLeastLamps = 3;
/// With so many, the others still check one another when one is left out.
constexpr std::size_t kLeastToLeaveOut = 5;

cv::Rect window_round(const Eigen::Vector2d& place_px) {
  return {static_cast<int>(std::lround(place_px.x())) - kHalfWindow_px,
          static_cast<int>(std::lround(place_px.y())) - kHalfWindow_px, 2 * kHalfWindow_px,
          2 * kHalfWindow_px};
}

std::vector<LampMove> moves_without(const std::vector<LampMove>& moves, std::size_t left_out) {
  std::vector<LampMove> others = moves;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
  return others;
}

double farthest_px(const MotionFit& fit) {
  double farthest = 0.0;
  for (const Eigen::Vector2d& residual : fit.residuals_px)
    farthest = std::max(farthest, residual.norm());
  return farthest;
}

/// Returns the index of the move without which the others hold; of several such moves, the one that
/// the others contradict most.
std::optional<std::size_t> odd_one(const std::vector<LampMove>& moves) {
  std::optional<std::size_t> odd;
  double least = 0.0;
  if (moves.size() < kLeastToLeaveOut) return odd;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto fit = fit_image_motion(moves_without(moves, i));
    if (!fit || !fit->holds() || (odd && fit->chi2 >= least)) continue;
    odd = i;
    least = fit->chi2;
  }
  return odd;
}

}  // namespace

std::vector<Eigen::Vector2d> places_px(const std::vector<ReferenceLamp>& lamps) {
  std::vector<Eigen::Vector2d> places;
  places.reserve(lamps.size());
  for (const ReferenceLamp& lamp : lamps) places.push_back(lamp.uv_px);
  return places;
}

std::optional<LampCenter> find_fixed_light(const Frame& frame, const Eigen::Vector2d& place_px,
                                           LampDetector& detector, CenterMethod method) {
  const Eigen::Vector2d corner(frame.region_px.x, frame.region_px.y);
  const Eigen::Vector2d place = place_px - corner;
  const std::vector<Blob>& blobs = detector.detect(frame.image, window_round(place));
  const auto distance = [&](const Blob& blob) { return (blob.uv_px - place).squaredNorm(); };
  const auto nearest =
      std::min_element(blobs.begin(), blobs.end(),
                       [&](const Blob& a, const Blob& b) { return distance(a) < distance(b); });
  if (nearest == blobs.end()) return std::nullopt;
  LampCenter center = measure_lamp(frame.image, *nearest, method);
  if (center.status != LampStatus::kOk) return std::nullopt;
  center.uv_px += corner;
  return center;
}

cv::Mat ReferenceWatch::without_lamps(const cv::Mat& image) const {
  if (lamps_.empty()) return image;
  cv::Mat blackened = image.clone();
  const cv::Rect whole({}, image.size());
  for (const ReferenceLamp& lamp : lamps_)
    blackened(window_round(motion_.now(lamp.uv_px)) & whole).setTo(0);
  return blackened;
}

bool ReferenceWatch::is_due(double t_s) const {
  if (lamps_.empty()) return false;
  return !looked_s_ || objection_ || t_s - *looked_s_ >= kReferencePeriod_s;
}

void ReferenceWatch::look(const Frame& frame) {
  if (lamps_.empty()) return;
  looked_s_ = frame.t_s;
  const std::vector<Sight> sights = find(frame);
  if (sights.size() < kLeastLamps) {
    objection_ = {fmt::format("{} of {} reference lamps are seen, fewer than {}", sights.size(),
                              lamps_.size(), kLeastLamps),
                  "uncover them, or calibrate again if the camera was moved"};
    return;
  }
  take_motion(sights);
}

std::vector<ReferenceWatch::Sight> ReferenceWatch::find(const Frame& frame) {
  std::vector<Sight> sights;
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    const ReferenceLamp& lamp = lamps_[i];
    const auto center = find_fixed_light(frame, motion_.now(lamp.uv_px), detector_, method_);
    if (!center) continue;
    const Eigen::Matrix2d then_px2 = lamp.sigma_px * lamp.sigma_px * Eigen::Matrix2d::Identity();
    sights.push_back({i, {lamp.uv_px, center->uv_px, center->covariance_px2 + then_px2}});
  }
  return sights;
}

void ReferenceWatch::take_motion(const std::vector<Sight>& sights) {
  std::vector<LampMove> moves;
  moves.reserve(sights.size());
  for (const Sight& sight : sights) moves.push_back(sight.move);
  auto fit = fit_image_motion(moves);
  if (fit && !fit->holds()) {
    if (const auto odd = odd_one(moves)) {
      fit = fit_image_motion(moves_without(moves, *odd));
      const LampMove& move = moves[*odd];
      name_knocked(lamps_[sights[*odd].lamp], {fit->motion.now(move.then_px), move.now_px, {}});
    }
  }
  if (!fit || !fit->holds()) {
    objection_ = {
        fmt::format("the reference lamps disagree by up to {:.3f} px, more than noise explains",
                    fit ? farthest_px(*fit) : 0.0),
        "lens or lamps have moved and the calibration is void: record and calibrate again"};
    return;
  }
  motion_ = fit->motion;
  objection_.reset();
  spdlog::debug(fmt::format("reference lamps: {} seen, chi squared {:.1f} of {}, up to {:.4f} px",
                            sights.size(), fit->chi2, fit->freedom, farthest_px(*fit)));
}

void ReferenceWatch::name_knocked(const ReferenceLamp& lamp, const LampMove& move) {
  if (knocked_ == lamp.id) return;
  knocked_ = lamp.id;
  spdlog::warn(fmt::format(
      "reference lamp {} is {:.3f} px from where the others predict it and is left out; was it "
      "knocked?",
      lamp.id, (move.now_px - move.then_px).norm()));
}

}  // namespace planar
