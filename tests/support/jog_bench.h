#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/jog/jog_console.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar::test {

struct JogAnswer {
  bool done{true};
  std::string text;
};

/// Performs a line; its fault becomes the answer.
inline JogAnswer execute(JogConsole& console, const std::string& line) {
  try {
    const auto command = parse_arm_command(line);
    return {true, command ? console.perform(*command) : ""};
  } catch (const InputError& error) {
    return {false, error.what()};
  } catch (const WorkError& error) {
    return {false, error.what()};
  }
}

/// A cell that is jogged: by default the paper's, whose vision is not calibrated.
struct JogBench {
  TemporaryFolder folder;
  CellSettings cell;
  std::unique_ptr<CellDevices> devices;
  std::filesystem::path table;
  JogConsole console;

  explicit JogBench(const CellSettings& settings = read_cell(paper_cell_file()))
      : cell(settings),
        devices(open_cell(cell)),
        table(folder.path() / "targets.csv"),
        console(read_calibrated_cell(cell), *devices, table) {}

  Pulses pulses() {
    Pulses all;
    const auto status = devices->drives().status();
    for (std::size_t i = 0; i < 3; ++i) all[static_cast<int>(i)] = status[i].target_pulses;
    return all;
  }
  std::string done(const std::string& line) {
    const auto answer = execute(console, line);
    INFO(line << " -> " << answer.text);
    CHECK(answer.done);
    return answer.text;
  }
  /// Refused, and nothing has moved.
  std::string refused(const std::string& line) {
    const Pulses before = pulses();
    const auto answer = execute(console, line);
    INFO(line << " -> " << answer.text);
    CHECK_FALSE(answer.done);
    CHECK(pulses() == before);
    return answer.text;
  }
  /// The elbow to a right angle.
  void bend() {
    done("enable");
    for (int i = 0; i < 2; ++i) done("joint 2 15");
  }
};

}  // namespace planar::test
