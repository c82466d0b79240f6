#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/calibration/readings/smooth_errors.h"

namespace planar {

/// The most likely explanation of the errors with or without some step, and the outliers that go
/// with it.
struct Explanation {
  SmoothFit fit;
  SmoothErrors::Outliers outliers;
  std::optional<StepShape> step{};
};

SmoothErrors::Outliers no_outliers(const SmoothErrors& errors);

/// Returns the explanation without a step.
Explanation without_step(const SmoothErrors& errors);

/// Returns the explanation with this step. It starts from the tuning of another, but without its
/// outliers, because a step after which few places come explains what otherwise are outliers.
Explanation with_step(const SmoothErrors& errors, const StepShape& step, const Explanation& start);

/// Returns the errors with outliers moved to where they stop being any: a few of them beside each
/// other may be a step.
Eigen::MatrixX2d with_outliers_moved(const SmoothErrors& errors, const Explanation& by);

}  // namespace planar
