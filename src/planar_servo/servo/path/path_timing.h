#pragma once

#include <vector>

#include "planar_servo/servo/path/path.h"

namespace planar {

/// Says when the end point is where on its path: it begins and ends at rest, and speeds up and
/// slows down evenly. At a corner it rests for a moment; on an arc it goes so slowly that
/// v^2 / radius keeps the acceleration.
class PathTiming {
 public:
  /// Throws std::invalid_argument unless speed (m/s) and acceleration (m/s^2) are positive.
  PathTiming(const Path& path, double speed_m_s, double acceleration_m_s2 = kAcceleration_m_s2);

  /// The usual acceleration: 50 mm/s is reached after 0.5 s and 12.5 mm.
  static constexpr double kAcceleration_m_s2{0.1};

  double duration_s() const { return end_s_; }
  /// Returns how far along the path the end point is; before the beginning and after the end it
  /// rests there.
  double along_m(double t_s) const;

 private:
  struct Phase {
    double begin_s, begin_m, speed_m_s, acceleration_m_s2;
  };
  /// Appends a way of `length_m` from one speed to another, at most at `top`, metres and seconds.
  void append(double length_m, double from, double to, double top);
  void append_phase(double duration_s, double speed_m_s, double acceleration_m_s2);

  double acceleration_;
  std::vector<Phase> phases_;
  double end_s_{0.0}, end_m_{0.0};
};

}  // namespace planar
