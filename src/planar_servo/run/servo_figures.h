#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/files/tables/result_table.h"

namespace planar {

/// Selects one of the errors of a TargetResult.
using TargetError = std::optional<Eigen::Vector2d> TargetResult::*;

/// Returns the lengths of an error at the targets where it is known, metres.
std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error);

/// Returns the mean of error_lengths(), or NaN when there are none.
double mean_error(const std::vector<TargetResult>& results, TargetError error);

/// Holds the figures of a run over the targets that were measured. A figure is empty when there is
/// none.
struct ServoFigures {
  std::size_t targets{0}, reached{0};
  double iterations_median{0.0};
  double seconds_per_target{0.0};
  std::optional<Summary> before_own, after_own, before_truth, after_truth;  ///< metres
  /// Share of the components of compensated vision minus truth within 1.96 stated deviations.
  std::optional<double> coverage_95;
  std::optional<FrameCounts> frames;  ///< of the camera; added by whoever has the camera
};

/// Computes the figures of a run without those of its camera.
ServoFigures figures_of(const std::vector<TargetResult>& results);

}  // namespace planar
