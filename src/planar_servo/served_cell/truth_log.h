#pragma once

#include <filesystem>
#include <optional>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/repeater.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/served_cell/live_cell.h"

namespace planar {

/// Writes where the tool really is, for the scorer only: t_s, x_mm, y_mm, phi_deg of P in the base
/// frame, whenever it has moved. The time is that of the computer's steady clock, by which a real
/// camera's frames are stamped; a row holds until the next one.
class TruthLog {
 public:
  /// Continues a truth log that is there. Throws as require_header() and GrowingFile do.
  TruthLog(const std::filesystem::path& file, LiveCell& live);

  /// Throws what has kept it from writing.
  void require_well() const { repeater_.require_well(); }

 private:
  void look();

  LiveCell& live_;
  GrowingFile file_;
  SteadyClock clock_;
  std::optional<TipPose> written_;
  Repeater repeater_;
};

}  // namespace planar
