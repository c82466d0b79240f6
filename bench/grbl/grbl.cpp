// build/release/bin/bench_grbl [--firmware build/release/tests/drives/firmware]
// build/release/bin/bench_grbl --moves 10000 --firmware build/release/tests/drives/firmware
// The first breaks boards at full speed, where they need 100 ms to brake: the emulated one, and
// Grbl and grblHAL themselves where they lie. Faults come over the line, because the simulators of
// the firmware have no inputs. The second sends the firmware random moves and holds the steps that
// it has made against those commanded.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "grbl_faults.h"
#include "grbl_start.h"
#include "grbl_steps.h"

namespace planar {
namespace {

struct Firmware {
  const char* name;
  const char* simulator;
};
constexpr Firmware kFirmware[] = {{"Grbl 1.1h", "grbl_sim"}, {"grblHAL", "grblHAL_sim"}};

int run(const std::filesystem::path& folder, int repeats, int moves) {
  bool right = true;
  if (moves == 0) {
    print_fault_table("emulated board", "", repeats);
    print_start_time(repeats);
  }
  for (const auto& [name, simulator] : kFirmware) {
    const auto path = folder / simulator;
    if (folder.empty() || !std::filesystem::exists(path))
      fmt::print("{}: no firmware; the test \"grbl_firmware: built\" makes it for --firmware\n",
                 name);
    else if (moves > 0)
      right = compare_steps(name, path, moves) && right;
    else
      print_fault_table(name, path, repeats);
  }
  return right ? 0 : 1;
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  CLI::App app("What Grbl drives make of faults, or the steps that real firmware makes.");
  int repeats = 5, moves = 0;
  std::filesystem::path folder;
  app.add_option("--firmware", folder, "folder of grbl_sim and grblHAL_sim");
  app.add_option("--repeats", repeats, "runs of each fault")->capture_default_str();
  app.add_option("--moves", moves, "random moves whose steps are compared, instead of faults");
  CLI11_PARSE(app, argc, argv);
  try {
    return planar::run(folder, repeats, moves);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_grbl: {}\n", error.what());
    return 1;
  }
}
