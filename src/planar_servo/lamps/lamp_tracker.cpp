#include "planar_servo/lamps/lamp_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar {
namespace {

// Below this cosine between seen and predicted direction the prediction does not tell the lamps
// apart.
constexpr double kLeastCosine = 0.2;
// Glow may make a lamp seem larger, and tilt the distance shorter.
constexpr double kSizeFactor = 1.6;
// Lamps whose sizes differ by less are not told apart by them.
constexpr double kTellingDiameters = 1.1;

bool has_right_distance(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!expectation.separation_px) return true;
  const double distance = (b.uv_px - a.uv_px).norm();
  return distance >= (*expectation.separation_px)[0] && distance <= (*expectation.separation_px)[1];
}

bool has_size(const Blob& blob, double expected_px, double factor) {
  const double ratio = blob.diameter_px() / expected_px;
  return ratio < factor && ratio > 1.0 / factor;
}

/// Returns whether a may be lamp 1 and b lamp 2.
bool is_possible(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!has_right_distance(a, b, expectation)) return false;
  if (!expectation.diameter_over_separation) return true;
  const auto [first, second] = *expectation.diameter_over_separation;
  const double distance = (b.uv_px - a.uv_px).norm();
  return has_size(a, first * distance, kSizeFactor) && has_size(b, second * distance, kSizeFactor);
}

/// Returns what the sizes say of this order: 1 for it, -1 against it, 0 nothing.
int vote_of_sizes(const Blob& a, const Blob& b, const PairExpectation& expectation) {
  if (!expectation.diameter_over_separation) return 0;
  const auto [first, second] = *expectation.diameter_over_separation;
  const double expected_log = std::log(second / first);
  if (std::abs(expected_log) < std::log(kTellingDiameters)) return 0;
  const double along = std::log(b.diameter_px() / a.diameter_px()) / expected_log;
  if (std::abs(along) < 0.5) return 0;
  return along > 0.0 ? 1 : -1;
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
  const int sizes = vote_of_sizes(a, b, expectation);
  if (predicted * sizes < 0 || predicted + sizes == 0) return choice;
  choice.status = LampStatus::kOk;
  if (predicted + sizes < 0) std::swap(choice.index[0], choice.index[1]);
  return choice;
}

namespace {

// Half the side of a window over the predicted distance of the lamps, which keeps the other lamp
// out.
constexpr double kWindowShare = 0.5;
constexpr double kLeastWindow_px = 16.0, kMostWindow_px = 256.0;
constexpr std::size_t kMostCandidates = 32;

/// Returns the place on the sensor of the image's first pixel.
Eigen::Vector2d corner_of(const Frame& frame) {
  return {frame.region_px.x, frame.region_px.y};
}

/// Returns the expectation in pixels of an image whose first pixel is `origin` on the sensor.
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

/// Returns the pair that is followed; its status is not kOk when a lamp is lost.
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

namespace {

constexpr double kReach = 3.0;       // diameters that a disc may have moved
constexpr double kRowShare = 0.2;    // of its diameter between two rows that are searched
constexpr double kSizeChange = 1.5;  // most change of its diameter between two images

template <typename Condition>
std::optional<Blob> nearest(const std::vector<Blob>& blobs, const Eigen::Vector2d& place,
                            const Condition& is_possible) {
  std::optional<Blob> best;
  for (const Blob& blob : blobs) {
    if (!is_possible(blob)) continue;
    if (!best || (blob.uv_px - place).norm() < (best->uv_px - place).norm()) best = blob;
  }
  return best;
}

}  // namespace

DiscTracker::DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px)
    : method_(method), start_px_(std::move(start_px)) {}

/// Returns the patch above half the last contrast that is nearest to the last place.
std::optional<Blob> DiscTracker::find_again(const cv::Mat& image) {
  const double diameter_px = last_->diameter_px();
  const auto threshold = static_cast<int>(std::lround(0.5 * (last_->level + last_->background)));
  const auto most_area = static_cast<int>(kSizeChange * kSizeChange * last_->area_px2);
  const int row_step = std::max(1, static_cast<int>(kRowShare * diameter_px));
  const cv::Rect window =
      window_round(last_->uv_px, kReach * diameter_px) & cv::Rect({0, 0}, image.size());
  patches_.start(image.size());
  found_.clear();
  for (int v = window.y; v < window.br().y; v += row_step) {
    const auto* row = image.ptr<std::uint8_t>(v);
    for (int u = window.x; u < window.br().x; ++u) {
      if (row[u] <= threshold) continue;
      const Span run = run_round(image, v, u, threshold);
      u = run.end;
      if (patches_.is_taken(run.begin, v, 0)) continue;
      const Patch patch = patches_.grow(image, run, threshold, 0, most_area);
      found_.push_back(describe_blob(image, patch.box_px, patches_.begin(patch),
                                     patches_.end(patch), threshold));
    }
  }
  return nearest(found_, last_->uv_px, [&](const Blob& blob) {
    return is_filled(blob) && has_size(blob, diameter_px, kSizeChange);
  });
}

/// Returns the disc that was selected, or the most evident one.
std::optional<Blob> DiscTracker::find_first(const cv::Mat& image) {
  const std::vector<Blob>& found = detector_.detect(image);
  if (!start_px_) return found.empty() ? std::nullopt : std::optional<Blob>(found.front());
  const cv::Point start(static_cast<int>(start_px_->x()), static_cast<int>(start_px_->y()));
  return nearest(found, *start_px_, [&](const Blob& blob) { return start.inside(blob.box_px); });
}

LampCenter DiscTracker::locate(const cv::Mat& image) {
  require_8_bit(image);
  if (const auto seen = dot_.track(image, {0.0, 0.0})) {
    last_ = seen->blob;
    return lamp_at_dot(image, *seen);
  }
  const std::optional<Blob> blob = last_ ? find_again(image) : find_first(image);
  if (!blob) return {};
  last_ = blob;
  if (method_ == CenterMethod::kVpDot2) dot_.start(image, {0.0, 0.0}, *blob);
  return measure_lamp(image, *blob, method_);
}

}  // namespace planar
