#include "planar_servo/certificate/pose_drift.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "planar_servo/certificate/certainty.h"
#include "planar_servo/certificate/pose_statistics.h"

namespace planar {
namespace {

constexpr std::size_t kParts = 3;

using Order = std::vector<std::size_t>;

/// Some cycles of a run in a given order.
struct SomeCycles {
  const std::vector<CycleErrors>& all;
  const Order& order;
  std::size_t begin, count;

  PoseErrors at_pose(std::size_t pose) const {
    PoseErrors errors;
    for (std::size_t i = begin; i < begin + count; ++i) errors.push_back(all[order[i]][pose]);
    return errors;
  }
  Eigen::Vector2d mean_error() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t pose = 0; pose < CycleErrors().size(); ++pose)
      sum += barycentre(at_pose(pose));
    return sum / static_cast<double>(CycleErrors().size());
  }
  double mean_of(double PoseAccuracy::*figure) const {
    double sum = 0.0;
    for (std::size_t pose = 0; pose < CycleErrors().size(); ++pose)
      sum += pose_accuracy(at_pose(pose)).*figure;
    return sum / static_cast<double>(CycleErrors().size());
  }
};

}  // namespace

std::optional<PoseDrift> pose_drift(const std::vector<CycleErrors>& cycles) {
  const std::size_t n = cycles.size();
  if (n < 2) return std::nullopt;
  PoseDrift drift;
  drift.cycles = std::max<std::size_t>(1, n / kParts);
  const auto first = [&](const Order& order) { return SomeCycles{cycles, order, 0, drift.cycles}; };
  const auto last = [&](const Order& order) {
    return SomeCycles{cycles, order, n - drift.cycles, drift.cycles};
  };
  const auto shift = [&](const Order& order) {
    return (last(order).mean_error() - first(order).mean_error()).norm();
  };
  Order as_run(n);
  std::iota(as_run.begin(), as_run.end(), std::size_t{0});
  const auto compared = [&](double PoseAccuracy::*figure) {
    return FirstAndLast{
        first(as_run).mean_of(figure), last(as_run).mean_of(figure),
        chance_level(n, [&](const Order& order) {
          return std::abs(last(order).mean_of(figure) - first(order).mean_of(figure));
        })};
  };
  drift.shift = shift(as_run);
  drift.shift_chance = chance_level(n, shift);
  drift.accuracy = compared(&PoseAccuracy::accuracy);
  if (drift.cycles >= 2) drift.repeatability = compared(&PoseAccuracy::repeatability);
  return drift;
}

}  // namespace planar
