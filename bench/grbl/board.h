#pragma once

#include <cmath>
#include <filesystem>
#include <optional>

#include "support/counted_firmware.h"
#include "support/grbl_bench.h"

namespace planar {

/// A board that the bench drives: emulated, or real firmware.
class BenchBoard {
 public:
  /// Without a simulator the board is emulated. The axes make `speed` pulses/s, and ten times as
  /// many pulses/s^2.
  BenchBoard(const std::filesystem::path& simulator, double speed_pulses_s) {
    settings_ = test::grbl_settings_of("");
    EmulatedGrbl::Settings stored{{1, 255}};
    const double per_minute = speed_pulses_s / settings_.axes[0].pulses_per_mm * grbl::kMinute_s;
    for (const int i : {0, 1, 2}) {
      settings_.axes[i].speed_pulses_s = speed_pulses_s;
      settings_.axes[i].acceleration_pulses_s2 = 10.0 * speed_pulses_s;
      stored[110 + i] = std::round(per_minute);
      stored[120 + i] = std::round(per_minute / 6.0);
    }
    if (simulator.empty())
      emulated_.emplace();
    else
      firmware_.emplace(simulator, stored);
    settings_.port = emulated_ ? emulated_->board.port() : firmware_->port();
  }

  /// Returns the settings of a cell that suits it.
  const GrblSettings& settings() const { return settings_; }
  /// Ends real firmware and returns the steps that its stepper interrupt has made, axes X to Z.
  std::array<int, 3> end() { return firmware_->end(); }

 private:
  GrblSettings settings_;
  std::optional<test::GrblBench> emulated_;
  std::optional<test::CountedFirmware> firmware_;
};

}  // namespace planar
