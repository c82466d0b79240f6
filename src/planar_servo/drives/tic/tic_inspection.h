#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/drives/tic/tic_bus.h"

namespace planar {

/// Holds what can be told of a Tic by reading only; nothing is switched on, moved or set.
struct TicInspection {
  std::optional<Refusal> refusal;  ///< why it cannot be used; what could be read is filled in
  TicListing listing;
  double supply_v{0.0};
  bool position_certain{false};
  /// Its errors without those that switching on clears.
  std::vector<std::string> faults;
};

TicInspection inspect_tic(TicBus& bus, const std::string& serial);

}  // namespace planar
