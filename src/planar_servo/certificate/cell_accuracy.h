#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/certificate/pose_statistics.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/tables/cycle_table.h"

namespace planar {

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

CellAccuracy cell_accuracy(const std::vector<JudgedMove>& moves);

}  // namespace planar
