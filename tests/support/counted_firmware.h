#pragma once

#include <array>

#include "planar_servo/machine/rehearsal/firmware_board.h"
#include "support/temporary_folder.h"

namespace planar::test {

/// Real firmware of a motion board whose steps are counted.
class CountedFirmware : private TemporaryFolder, public FirmwareBoard {
 public:
  /// Starts the simulator of Grbl or of grblHAL, with these settings.
  CountedFirmware(const std::filesystem::path& simulator, const EmulatedGrbl::Settings& settings);

  /// Ends it and returns the steps that its stepper interrupt has made, axes X to Z.
  std::array<int, 3> end();
};

}  // namespace planar::test
