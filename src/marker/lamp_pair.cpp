#include "marker/lamp_pair.h"

#include <cmath>
#include <limits>

namespace planar {
namespace {

// Cosine between seen and predicted direction below which they do not tell the lamps apart.
constexpr double kLeastCosine = 0.2;

bool has_right_distance(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const PairExpectation& expectation) {
  if (!expectation.separation_px) return true;
  const double distance = (b - a).norm();
  return distance >= (*expectation.separation_px)[0] && distance <= (*expectation.separation_px)[1];
}

}  // namespace

PairChoice choose_pair(const std::vector<Eigen::Vector2d>& candidates_px,
                       const PairExpectation& expectation) {
  PairChoice choice;
  if (candidates_px.size() < 2) {
    choice.status = candidates_px.empty() ? LampStatus::kNoLamp : LampStatus::kOneLamp;
    return choice;
  }
  choice.status = LampStatus::kWrongDistance;
  const auto& predicted = expectation.predicted_px;
  double least = std::numeric_limits<double>::infinity();
  std::size_t admissible = 0;
  for (std::size_t j = 1; j < candidates_px.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      if (!has_right_distance(candidates_px[i], candidates_px[j], expectation)) continue;
      ++admissible;
      for (const auto& index : {std::array<std::size_t, 2>{i, j}, {j, i}}) {
        const double misfit = predicted
                                  ? (candidates_px[index[0]] - (*predicted)[0]).squaredNorm() +
                                        (candidates_px[index[1]] - (*predicted)[1]).squaredNorm()
                                  : static_cast<double>(admissible);
        if (misfit < least) {
          least = misfit;
          choice.index = index;
        }
      }
    }
  }
  if (admissible == 0) return choice;
  choice.status = LampStatus::kAmbiguous;
  choice.is_unique = predicted || admissible == 1;
  if (!predicted) return choice;
  const Eigen::Vector2d seen = candidates_px[choice.index[1]] - candidates_px[choice.index[0]];
  const Eigen::Vector2d expected = (*predicted)[1] - (*predicted)[0];
  if (seen.dot(expected) > kLeastCosine * seen.norm() * expected.norm()) {
    choice.status = LampStatus::kOk;
  }
  return choice;
}

}  // namespace planar
