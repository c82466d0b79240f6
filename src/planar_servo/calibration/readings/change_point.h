#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace planar {

/// The vision error at one place, in the order of time; metres.
struct TimedError {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
  double phi{0.0};  ///< direction of the tool, radians
};

/// The frame in which what changes at a step is constant.
enum class StepFrame { kBase, kTool };

/// A place after which all errors differ by the same amount.
struct ChangePoint {
  std::size_t first{0};  ///< the first place after the change
  Eigen::Vector2d step{0.0, 0.0};
  double sigma{0.0};  ///< of the step per axis
  /// The frame in which the step is constant; empty where the tool always points the same way.
  std::optional<StepFrame> frame{};
  /// The errors at `places` less what field and drift explain; in the step's frame, the step
  /// included.
  std::vector<Eigen::Vector2d> left{};
  std::vector<std::size_t> places{};  ///< those that were examined, in order of time

  /// Returns the mean error over the field that the step causes in a map of all `count` places,
  /// metres. Which state lasts is not known; the one with fewer places is assumed.
  double cost(std::size_t count) const;
};

/// Errors that drift over all places.
struct ErrorTrend {
  Eigen::Vector2d size{0.0, 0.0};  ///< from the first place to the last, metres
  double sigma{0.0};               ///< of it per axis
  /// The frame in which they drift; empty where the tool always points the same way.
  std::optional<StepFrame> frame{};
};

/// Looks for one step in time. The errors are explained with and without a step, each with its most
/// likely tuning and outliers; the ratio of the likelihoods decides. The false alarm of all places
/// together is at most kFalseAlarm. Each side of a step has at least five places. Of more than 500
/// places only every second, third, ... is examined. Empty for fewer than 32 places.
std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors);

/// Returns the noise per axis that remains of the errors beside field, drift and outliers, metres;
/// empty for fewer than 32 places.
std::optional<double> noise_of(const std::vector<TimedError>& errors);

/// Looks for a linear trend in time, as find_change() looks for a step; errors that do not drift
/// are called drifting once in 1 / kFalseAlarm recordings.
/// Empty, too, where places were visited in such an order that the field explains it as well.
std::optional<ErrorTrend> find_trend(const std::vector<TimedError>& errors);

}  // namespace planar
