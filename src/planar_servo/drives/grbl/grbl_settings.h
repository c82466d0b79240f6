#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/error.h"
#include "planar_servo/drives/grbl/grbl_protocol.h"

namespace planar {

/// One joint's axis of a Grbl board, as the cell has it.
struct GrblAxis {
  char letter{'X'};
  double pulses_per_mm{250.0};
  double speed_pulses_s{0.0};
  double acceleration_pulses_s2{0.0};
  HomeReference home{HomeReference::kTaught};

  /// Returns 0 for X to 2 for Z.
  std::size_t index() const { return static_cast<std::size_t>(letter - 'X'); }
};

/// A Grbl board with an axis for each joint.
struct GrblSettings {
  std::string port;  ///< "/dev/serial/by-id/..."
  int baud{115200};
  std::array<GrblAxis, 3> axes;
};

namespace grbl {

/// The longest time for which a board may go on moving when its program has died.
constexpr double kLongestRun_s = 0.19;
/// The shortest time for which a board at full speed must have motion beyond its braking way, so
/// that it does not brake whenever this machine pauses.
constexpr double kReserve_s = 0.04;

/// Returns whether whole pulses are lengths that a board can be told and tells, in thousandths of a
/// millimetre.
bool keeps_pulses(double pulses_per_mm);

/// Says why a board with this version and these settings cannot serve the cell; empty when it can.
std::optional<Refusal> unfitness(const Banner& version, const Settings& settings,
                                 const GrblSettings& cell);

}  // namespace grbl
}  // namespace planar
