#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "planar_servo/certificate/pose_statistics.h"

namespace planar {

/// Two ends between which a figure lies with kCertainty.
using Interval = std::pair<double, double>;

/// The confidence of every interval, and the share of chance that a level keeps below it.
constexpr double kCertainty = 0.95;
/// Fewer values than this give no interval.
constexpr std::size_t kLeastForInterval = 6;

/// The intervals of AP and RP of one pose.
struct PoseIntervals {
  Interval accuracy, repeatability;
};

/// Returns the intervals of pose_accuracy(), from sets drawn anew out of the normal distribution
/// that has the errors' mean and covariance: AP by the basic bootstrap, RP, which scales with the
/// scatter, by its ratio [Davison and Hinkley 1997, 5.2]. Empty for fewer than kLeastForInterval
/// errors.
std::optional<PoseIntervals> pose_intervals(const PoseErrors& errors);

/// Returns the interval of a figure of values that are drawn alike, from values drawn anew out of
/// themselves (percentile bootstrap). Empty for fewer than kLeastForInterval values.
std::optional<Interval> figure_interval(
    const std::vector<double>& values,
    const std::function<double(const std::vector<double>&)>& figure);

/// Returns what chance alone lets a figure of n things reach with kCertainty where their order
/// means nothing: the quantile over orders that are drawn. `figure` takes the order.
double chance_level(std::size_t n,
                    const std::function<double(const std::vector<std::size_t>& order)>& figure);

}  // namespace planar
