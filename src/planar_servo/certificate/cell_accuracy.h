#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/files/tables/result_table.h"

namespace planar {

/// Errors of one pose that was commanded again and again: attained minus commanded place, metres.
using PoseErrors = std::vector<Eigen::Vector2d>;

/// Accuracy and repeatability of a pose, metres or radians.
struct PoseAccuracy {
  double accuracy{0.0};       ///< AP
  double repeatability{0.0};  ///< RP
};

// The figures of ISO 9283:1998 in the plane: z is left out. All throw std::invalid_argument for
// empty sets.

Eigen::Vector2d barycentre(const PoseErrors& errors);

/// Returns AP = |mean of the errors| and RP = mean l + 3 S_l [ISO 9283:1998, 7.2], with the
/// distances l from the barycentre and their standard deviation S_l over n - 1. RP is NaN for fewer
/// than two errors.
PoseAccuracy pose_accuracy(const PoseErrors& errors);

/// Returns the same for an angle: AP = |mean|, RP = 3 S over n - 1, radians.
PoseAccuracy angle_accuracy(const std::vector<double>& errors);

/// Returns the multi-directional pose accuracy variation vAP: the greatest distance between the
/// barycentres of one pose that was approached from several directions [ISO 9283:1998, 7.2.4].
double direction_variation(const std::vector<PoseErrors>& by_direction);

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

/// Returns the intervals of pose_accuracy(), from sets drawn from the normal distribution with the
/// errors' mean and covariance: AP by the basic bootstrap, with the percentile's upper end where it
/// is higher, as a length near zero is seldom found too short; RP, which scales with the scatter,
/// by its ratio [Davison and Hinkley 1997, 5.2]. Empty for fewer than kLeastForInterval errors.
std::optional<PoseIntervals> pose_intervals(const PoseErrors& errors);

/// Returns the interval of a figure of values of one distribution, by resampling them (percentile
/// bootstrap). Empty for fewer than kLeastForInterval values.
std::optional<Interval> figure_interval(
    const std::vector<double>& values,
    const std::function<double(const std::vector<double>&)>& figure);

/// Returns the limit that a figure of n things keeps with kCertainty where their order means
/// nothing: its quantile over random orders. `figure` takes the order.
double chance_level(std::size_t n,
                    const std::function<double(const std::vector<std::size_t>& order)>& figure);

/// Errors at P1 to P5 in one cycle, metres.
using CycleErrors = std::array<Eigen::Vector2d, 5>;

/// A figure of the first and of the last cycles, and how much chance alone lets the two differ.
struct FirstAndLast {
  double first{0.0}, last{0.0};
  double chance{0.0};  ///< the difference stays below it with kCertainty where nothing drifts
};

/// The change of accuracy during a run. Metres, means over the poses.
struct PoseDrift {
  std::size_t cycles{0};  ///< as many of the first are compared with as many of the last
  double shift{0.0};      ///< of the mean error vector
  double shift_chance{0.0};
  FirstAndLast accuracy;                        ///< AP
  std::optional<FirstAndLast> repeatability{};  ///< RP; needs two cycles on either side
};

/// Compares the first third of the cycles with the last third, at least one cycle each. The part of
/// chance is found by shuffling the cycles. Empty for fewer than two cycles.
std::optional<PoseDrift> pose_drift(const std::vector<CycleErrors>& cycles);

/// The accuracy found at one pose. Metres and radians.
struct PoseFigures {
  std::string name;
  Eigen::Vector2d p{0.0, 0.0};
  std::size_t cycles{0};
  PoseAccuracy position;
  std::optional<PoseIntervals> intervals;
  std::optional<PoseAccuracy> turn;  ///< where the judge sees the tool's direction
};

/// The accuracy found at one pose that was approached from several directions.
struct DirectionFigures {
  std::string name;
  std::size_t directions{0}, cycles{0};  ///< cycles from each direction
  double variation{0.0};                 ///< vAP, metres
  double chance{0.0};                    ///< scatter alone keeps vAP below it with kCertainty
};

/// The accuracy found over the workspace. Metres.
struct WorkspaceFigures {
  Summary errors;
  std::optional<Interval> mean, rms, p95;
  /// The share of the workspace that with kCertainty has errors below the largest one found.
  double below_max{0.0};
  std::optional<double> turn_rms;  ///< radians
};

/// The accuracy of a cell by its judged moves. Only moves that count are in the figures.
struct CellAccuracy {
  std::size_t moves{0}, reached{0}, judged{0};
  std::vector<PoseFigures> poses;
  std::vector<DirectionFigures> directions;
  std::optional<PoseDrift> drift;
  std::optional<WorkspaceFigures> workspace;
  double seconds{0.0};      ///< of all moves that were to be judged
  double judge_sigma{0.0};  ///< the largest standard uncertainty of the judge per axis, metres

  /// Return the pose with the largest AP, RP and vAP. There must be one.
  const PoseFigures& worst_accuracy() const;
  const PoseFigures& worst_repeatability() const;
  const DirectionFigures& worst_variation() const;
};

/// Returns the moves of a part that count.
std::vector<const JudgedMove*> counted(const std::vector<JudgedMove>& moves, CertificatePart part);

CellAccuracy cell_accuracy(const std::vector<JudgedMove>& moves);

}  // namespace planar
