#include "support/counted_firmware.h"

#include <cstdio>
#include <fstream>

namespace planar::test {
namespace {

constexpr const char* kSteps = "steps";

/// Between two rows of the steps passes so much time that there are only those at the end of each
/// block. The simulator of grblHAL takes a byte per pass of its main loop, and passes only when it
/// does not wait for real time.
std::vector<std::string> options_of(const std::filesystem::path& simulator) {
  return {"-s", kSteps, "-r", "1e6", "-t", simulator.filename() == "grbl_sim" ? "1" : "0"};
}

}  // namespace

CountedFirmware::CountedFirmware(const std::filesystem::path& simulator,
                                 const EmulatedGrbl::Settings& settings)
    : FirmwareBoard(simulator, options_of(simulator), settings, path() / "port") {}

std::array<int, 3> CountedFirmware::end() {
  std::array<int, 3> steps{};
  std::ifstream file(FirmwareBoard::end() / kSteps);
  for (std::string row; std::getline(file, row);) {
    std::array<int, 3> read{};
    if (std::sscanf(row.c_str(), "%*f %d, %d, %d", &read[0], &read[1], &read[2]) == 3) steps = read;
  }
  return steps;
}

}  // namespace planar::test
