#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

/// By how much the tip misses, anew at every stop. A stop is a rest of a tenth of a second or more:
/// the short one of an approach from one side is none, so that the length of a move is that between
/// the places where the arm really stopped.
class StopScatter {
 public:
  StopScatter(const ScatterTruth& truth, std::uint64_t seed) : truth_(truth), seed_(seed) {}

  /// Returns the miss, base frame, of an arm that rests where its motors lead the tip to `p_m`.
  /// `negative` says that motor 1 arrived turning backwards.
  Eigen::Vector2d at_rest(const Eigen::Vector2d& p_m, bool negative) const;

  /// The arm leaves a place where it rested for so long; the other arguments are those of
  /// at_rest().
  void leave(const Eigen::Vector2d& p_m, bool negative, double rested_s);

  /// Returns the miss of an arm that moves: that of its last rest.
  const Eigen::Vector2d& moving() const { return kept_m_; }

 private:
  ScatterTruth truth_;
  std::uint64_t seed_;
  std::uint64_t stops_{0};
  std::optional<Eigen::Vector2d> last_stop_m_;
  Eigen::Vector2d kept_m_{0.0, 0.0};
};

}  // namespace planar
