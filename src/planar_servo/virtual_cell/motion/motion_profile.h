#pragma once

#include <vector>

namespace planar {

struct MotionState {
  double position{0.0};
  double velocity{0.0};
};

struct MotionLimits {
  double speed{1.0};
  double acceleration{1.0};
};

/// The fastest motion with bounded speed and acceleration from a moving start to rest at a target.
/// It is a trapezoid; when the start moves away from the target, or too fast to stop at it, the
/// motion stops first.
class MotionProfile {
 public:
  /// Rests at `position`.
  explicit MotionProfile(double position) : end_{position, 0.0} {}
  MotionProfile(double start_s, const MotionState& start, double target,
                const MotionLimits& limits);

  MotionState state_at(double t_s) const;
  double end_s() const { return end_s_; }

  /// Returns the positions, passed in (from_s, to_s], at which the velocity may change its sign.
  /// The motion between two of them is monotone.
  std::vector<double> turning_points(double from_s, double to_s) const;

 private:
  struct Phase {
    double start_s;
    MotionState start;
    double acceleration;
  };
  /// Appends a phase that begins where the last one ended.
  void append(double acceleration, double duration_s);

  std::vector<Phase> phases_;
  MotionState end_;  ///< after all phases
  double end_s_{0.0};
};

}  // namespace planar
