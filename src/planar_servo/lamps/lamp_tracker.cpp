#include "planar_servo/lamps/lamp_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

// Below this cosine between seen and predicted direction the prediction does not tell the lamps
// apart.
constexpr double kLeastCosine = 0.2;
// Glow may make a lamp seem larger, and tilt the distance shorter.
constexpr double kSizeFactor = 1.6;
// Lamps whose sizes or contrasts differ by less are not told apart by them.
constexpr double kTellingDiameters = 1.1, kTellingContrasts = 1.25;

bool has_right_distance(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!expectation.separation_px) return true;
  const double distance = (b.uv_px - a.uv_px).norm();
  return distance >= (*expectation.separation_px)[0] && distance <= (*expectation.separation_px)[1];
}

bool has_size(const Blob& blob, double expected_px) {
  const double ratio = blob.diameter_px() / expected_px;
  return ratio < kSizeFactor && ratio > 1.0 / kSizeFactor;
}

/// Returns whether a may be lamp 1 and b lamp 2.
bool is_possible(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!has_right_distance(a, b, expectation)) return false;
  if (!expectation.diameter_over_separation) return true;
  const auto [first, second] = *expectation.diameter_over_separation;
  const double distance = (b.uv_px - a.uv_px).norm();
  return has_size(a, first * distance) && has_size(b, second * distance);
}

/// Returns what a ratio of lamp 2 to lamp 1 says of this order: 1 for it, -1 against it, 0 nothing.
int vote(double seen, double expected, double least_telling) {
  const double seen_log = std::log(seen), expected_log = std::log(expected);
  if (std::abs(expected_log) < std::log(least_telling)) return 0;
  const double along = seen_log / expected_log;
  if (std::abs(along) < 0.5) return 0;
  return along > 0.0 ? 1 : -1;
}

/// Returns the vote of sizes and contrasts; 0 where these contradict each other.
int vote_of_looks(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  int sizes = 0, contrasts = 0;
  if (expectation.diameter_over_separation) {
    const auto [first, second] = *expectation.diameter_over_separation;
    sizes = vote(b.diameter_px() / a.diameter_px(), second / first, kTellingDiameters);
  }
  if (expectation.contrast_ratio)
    contrasts = vote(b.contrast() / a.contrast(), *expectation.contrast_ratio, kTellingContrasts);
  if (sizes * contrasts < 0) return 0;
  return sizes != 0 ? sizes : contrasts;
}

int vote_of_prediction(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!expectation.predicted_px) return 0;
  const Eigen::Vector2d seen = b.uv_px - a.uv_px;
  const Eigen::Vector2d expected = (*expectation.predicted_px)[1] - (*expectation.predicted_px)[0];
  const double cosine = seen.dot(expected) / (seen.norm() * expected.norm());
  if (std::abs(cosine) <= kLeastCosine) return 0;
  return cosine > 0.0 ? 1 : -1;
}

double misfit(const Blob& a, const Blob& b, const std::array<Eigen::Vector2d, 2>& predicted_px) {
  return (a.uv_px - predicted_px[0]).squaredNorm() + (b.uv_px - predicted_px[1]).squaredNorm();
}

}  // namespace

PairChoice choose_pair(const std::vector<Blob>& candidates, const PairExpectation& expectation) {
  PairChoice choice;
  if (candidates.size() < 2) {
    choice.status = candidates.empty() ? LampStatus::kNoLamp : LampStatus::kOneLamp;
    return choice;
  }
  choice.status = LampStatus::kWrongDistance;
  double least = std::numeric_limits<double>::infinity();
  int pairs = 0;
  for (std::size_t j = 1; j < candidates.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      bool is_pair = false;
      for (const auto& [a, b] : {std::array<std::size_t, 2>{i, j}, {j, i}}) {
        if (!is_possible(candidates[a], candidates[b], expectation)) continue;
        is_pair = true;
        const double misfit_here = expectation.predicted_px ? misfit(candidates[a], candidates[b],
                                                                     *expectation.predicted_px)
                                                            : pairs;
        if (misfit_here >= least) continue;
        least = misfit_here;
        choice.index = {a, b};
      }
      pairs += is_pair ? 1 : 0;
    }
  }
  if (pairs == 0) return choice;
  choice.status = LampStatus::kAmbiguous;
  choice.is_unique = expectation.predicted_px || pairs == 1;
  if (!choice.is_unique) return choice;
  const Blob &a = candidates[choice.index[0]], &b = candidates[choice.index[1]];
  const int predicted = vote_of_prediction(a, b, expectation);
  const int looks = vote_of_looks(a, b, expectation);
  if (predicted * looks < 0 || predicted + looks == 0) return choice;
  choice.status = LampStatus::kOk;
  if (predicted + looks < 0) std::swap(choice.index[0], choice.index[1]);
  return choice;
}

namespace {

// Half the side of a window over the predicted distance of the lamps: the other lamp stays out.
constexpr double kWindowShare = 0.5;
constexpr double kLeastWindow_px = 16.0, kMostWindow_px = 256.0;
constexpr std::size_t kMostCandidates = 32;

/// The first pixel of the frame's image on the sensor.
Eigen::Vector2d corner_of(const Frame& frame) {
  return {frame.region_px.x, frame.region_px.y};
}

/// The expectation in pixels of an image whose first pixel is `origin` on the sensor.
PairExpectation shifted(PairExpectation expectation, const Eigen::Vector2d& origin) {
  if (expectation.predicted_px)
    for (Eigen::Vector2d& uv : *expectation.predicted_px) uv -= origin;
  for (Eigen::Vector2d& uv : expectation.fixed_px) uv -= origin;
  return expectation;
}

}  // namespace

void LampTracker::search_windows(const cv::Mat& image, const PairExpectation& expectation) {
  candidates_.clear();
  if (!expectation.predicted_px) return;
  const auto& [first, second] = *expectation.predicted_px;
  const double half_side =
      std::clamp(kWindowShare * (second - first).norm(), kLeastWindow_px, kMostWindow_px);
  for (const Eigen::Vector2d& place : *expectation.predicted_px) {
    for (const Blob& blob : detector_.detect(image, window_round(place, half_side))) {
      const auto is_same = [&](const Blob& other) { return other.box_px == blob.box_px; };
      if (std::none_of(candidates_.begin(), candidates_.end(), is_same))
        candidates_.push_back(blob);
    }
  }
  drop_fixed(expectation.fixed_px);
}

void LampTracker::search_image(const cv::Mat& image, const PairExpectation& expectation) {
  const std::vector<Blob>& found = detector_.detect(image);
  const std::size_t n = std::min(found.size(), kMostCandidates);
  candidates_.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n));
  drop_fixed(expectation.fixed_px);
}

void LampTracker::drop_fixed(const std::vector<Eigen::Vector2d>& fixed_px) {
  const auto is_fixed = [&](const Blob& blob) {
    return std::any_of(fixed_px.begin(), fixed_px.end(), [&](const Eigen::Vector2d& place) {
      return (blob.uv_px - place).norm() < blob.diameter_px();
    });
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), is_fixed),
                    candidates_.end());
}

template <typename Measure>
LampPair LampTracker::choose(const PairExpectation& expectation, const Measure& measure) const {
  const PairChoice choice = choose_pair(candidates_, expectation);
  LampPair pair;
  pair.status = choice.status;
  if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous) return pair;
  for (std::size_t i : {0u, 1u}) {
    pair.lamps[i] = measure(i, choice.index[i]);
    if (pair.lamps[i].status != LampStatus::kOk) pair.status = pair.lamps[i].status;
  }
  if (!choice.is_unique) pair.lamps[0].status = pair.lamps[1].status = LampStatus::kAmbiguous;
  return pair;
}

LampPair LampTracker::measure(const Frame& frame, const PairExpectation& expectation) {
  return choose(expectation, [&](std::size_t lamp, std::size_t candidate) {
    const Blob& blob = candidates_[candidate];
    if (method_ == CenterMethod::kVpDot2) dots_[lamp].start(frame.image, corner_of(frame), blob);
    return measure_lamp(frame.image, blob, method_);
  });
}

/// The pair that is followed; without status kOk when a lamp is lost.
LampPair LampTracker::follow(const Frame& frame, const PairExpectation& expectation) {
  candidates_.clear();
  std::vector<VpDot> seen;
  for (VpDotTracker& dot : dots_) {
    const auto lamp = dot.track(frame.image, corner_of(frame));
    if (!lamp || (!seen.empty() && lamp->blob.box_px == seen[0].blob.box_px)) return {};
    seen.push_back(*lamp);
    candidates_.push_back(lamp->blob);
  }
  return choose(expectation, [&](std::size_t, std::size_t candidate) {
    return lamp_at_dot(frame.image, seen[candidate]);
  });
}

LampPair LampTracker::search(const Frame& frame, const PairExpectation& expectation) {
  forget();
  search_windows(frame.image, expectation);
  LampPair pair = measure(frame, expectation);
  if (pair.status != LampStatus::kOk) {
    search_image(frame.image, expectation);
    pair = measure(frame, expectation);
  }
  return pair;
}

LampPair LampTracker::locate(const Frame& frame, const PairExpectation& expectation) {
  require_8_bit(frame.image);
  const PairExpectation local = shifted(expectation, corner_of(frame));
  LampPair pair = follow(frame, local);
  const bool is_unnamed = pair.status == LampStatus::kAmbiguous && !local.predicted_px;
  if (pair.status != LampStatus::kOk && !is_unnamed) pair = search(frame, local);
  for (LampCenter& lamp : pair.lamps) lamp.uv_px += corner_of(frame);
  return pair;
}

void LampTracker::forget() {
  for (VpDotTracker& dot : dots_) dot.forget();
}

}  // namespace planar
