#include "planar_servo/lamps/lamp_pair.h"

#include <cmath>
#include <limits>

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

}  // namespace planar
