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
};

/// A place from which on all errors differ by the same amount.
struct ChangePoint {
  std::size_t first{0};  ///< the first place after the change
  Eigen::Vector2d step{0.0, 0.0};
  double sigma{0.0};    ///< of the step per axis
  double scatter{0.0};  ///< per axis, of the errors that step, place and time leave
};

/// Looks for one step in time. The errors are a cubic of the place, a trend in time and noise; a
/// step from place k on is held against none by the ratio of the mean squares, which for noise
/// follows F with two degrees of freedom above. What neighbours in time share, because the cubic
/// does not follow the field and neighbours in time are neighbours in space, lowers the number of
/// independent places: by (1 - r) / (1 + r), with the correlation r of successive remainders. The
/// false alarm of all k together is at most kFalseAlarm. Single outliers are not taken for a step.
/// Empty for fewer than 32 places.
std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors);

}  // namespace planar
