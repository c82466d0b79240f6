#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/field/joint_estimate.h"

namespace planar {

/// A reading that was left out, at the end point as vision sees it without compensation.
struct HeldOutReading {
  Eigen::Vector2d p_seen{0.0, 0.0};
  Eigen::Vector2d raw{0.0, 0.0};    ///< vision minus tracker, uncompensated
  Eigen::Vector2d left{0.0, 0.0};   ///< the same, compensated
  Eigen::Vector2d sigma{0.0, 0.0};  ///< of `left` per axis, as stated
};

/// How well places are met whose readings and pictures the fit has not seen. Lengths are in metres.
struct HeldOut {
  std::size_t n{0};         ///< readings that were judged
  double raw_rms{0.0};      ///< of vision minus tracker at the end point, uncompensated
  double rms{0.0};          ///< the same, compensated
  double coverage_95{0.0};  ///< share of the components within 1.96 stated deviations
  std::vector<HeldOutReading> readings;
  bool worth_using() const { return n > 0 && rms < raw_rms; }
  MapQuality quality() const { return {n, worth_using(), coverage_95}; }
};

/// Judges samples by an estimate from the others, which were `used`.
using JudgeLeftOut =
    std::function<void(const JointEstimate& without, const std::vector<PoseSample>& used,
                       const std::vector<PoseSample>& left_out)>;

/// Leaves out the places of `samples` with readings in ten parts, one part after the other, and has
/// each judged by a fit to the others with the estimate's priors. What the estimate left out is
/// neither used nor judged. Throws WorkError where the others do not determine the fit.
void leave_out_parts(const JointEstimate& estimate, const std::vector<PoseSample>& samples,
                     const LaidDots& board, const JudgeLeftOut& judge);

/// Predicts each part of leave_out_parts() from the others. Without readings nothing is judged.
HeldOut hold_out(const JointEstimate& estimate, const std::vector<PoseSample>& samples,
                 const LaidDots& board = {});

}  // namespace planar
