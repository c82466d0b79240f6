#pragma once

#include <Eigen/Core>
#include <mutex>
#include <vector>

namespace planar {

/// The way that motors have gone, for whoever follows it later: no turn of a motor is lost, and
/// steps on in the same direction take no room. Safe to use from any thread.
class MotorTrail {
 public:
  using Pulses = Eigen::Vector3i;

  void add(const Pulses& pulses);
  /// Returns the places since the last call at which a motor turned back, and the last place.
  std::vector<Pulses> take();

 private:
  std::mutex mutex_;
  std::vector<Pulses> places_;
};

}  // namespace planar
