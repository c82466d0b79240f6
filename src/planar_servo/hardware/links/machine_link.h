#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// What a machine says of itself. Counts are its own, from wherever it counts.
struct MachineState {
  Pulses counts{0, 0, 0};
  bool on{false};
  bool moving{false};
  bool homing{false};  ///< it searches a home switch
  int losses{0};       ///< so often its counts ceased to be those of the motors, as after a stall
  std::vector<std::string> faults{};
  bool emergency{false};        ///< its emergency stop is pressed, also by its own start
  bool stopped_by_hand{false};  ///< a person or a safety circuit may have stopped it
  std::string mover{};          ///< what says that it moves
};

/// How long a straight move takes, and each of the two parts in which it speeds up and slows down.
struct MoveTime {
  double duration_s{0.0}, ramp_s{0.0};
};

/// Returns the shortest time of a straight move by `way` counts that keeps these limits.
inline MoveTime time_of(const Pulses& way, const std::array<DriveLimits, 3>& limits) {
  const auto& [first, second, third] = limits;
  const auto [speed, acceleration] = straight_pace(
      way.cast<double>(), {first.speed_pulses_s, second.speed_pulses_s, third.speed_pulses_s},
      {first.acceleration_pulses_s2, second.acceleration_pulses_s2, third.acceleration_pulses_s2});
  if (std::isinf(speed)) return {};
  const double ramp_s = std::min(speed / acceleration, std::sqrt(1.0 / acceleration));
  return {1.0 / (acceleration * ramp_s) + ramp_s, ramp_s};
}

/// Reports that a machine does not do what it was told, and stands as before.
class MachineRefusal : public WorkError {
 public:
  using WorkError::WorkError;
};

/// A controller of three motors that moves them by itself once it is told where to. Every function
/// throws WorkError when it is out of touch or says what cannot be; the link is closed then, which
/// stops the machine as far as its kind can. After a MachineRefusal it is not, but for one of
/// read(): then the machine is told to stop first.
class MachineLink {
 public:
  virtual ~MachineLink() = default;
  /// Switches the motors on, also after a fault; none moves.
  virtual void switch_on() = 0;
  /// Starts a straight move from rest to rest, within these limits.
  virtual void go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) = 0;
  /// Begins to brake to rest; read() tells when it rests.
  virtual void stop() = 0;
  /// Starts the search for the home switch of a joint, counted from 0.
  virtual void search_home(int joint, HomeDirection direction) = 0;
  /// Is called every few milliseconds while the machine moves.
  virtual MachineState read() = 0;
  /// Returns what to look at where a move that was taken does not begin.
  virtual const char* starter() const = 0;
};

}  // namespace planar
