// Whatever its bytes, a reader of files returns or throws InputError. The variable PLANAR_READER of
// the environment names the reader, which finds them in the working directory; tests/fuzz/run goes
// through all that have seeds.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/drawings/drawing.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"
#include "planar_servo/hardware/links/modbus_map.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// A stream's lines are answered one by one; a bad one does not end it.
void read_stream(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  TargetLines lines("stream");
  for (std::string line; std::getline(in, line);) {
    try {
      lines.next(line);
    } catch (const InputError&) {
      if (!lines.has_columns()) return;
    }
  }
}

/// A tracker's program writes lines; a bad one does not end the stream. The first byte chooses
/// between columns with names and counted ones.
void read_tracker_stream(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  TrackerDialect dialect;
  if (in.get() == '#')
    dialect = {{';', true, {{"x_mm", "2"}, {"y_mm", "3"}, {"z_mm", "4"}, {"t_s", "1"}}}};
  TrackerLines lines("stream", dialect);
  for (std::string line; std::getline(in, line);) {
    try {
      lines.next(line);
    } catch (const InputError&) {
    }
  }
}

/// A board's lines are understood one by one.
void read_board_lines(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line);) grbl::parse_line(line);
}

/// Goes as far with a drawing as a run does before it asks the cell.
void read_drawn(const fs::path& path) {
  const Drawing drawing = read_drawing(path, {{}, 1e-3});
  if (!drawing.points.empty()) targets_of(drawing, path);
  PathTiming(path_of(drawing, 0.0, path), 0.01).duration_s();
}

struct Reader {
  const char* file;  ///< the name under which the reader is given its bytes
  std::function<void(const fs::path&)> read;
};

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"cell", {"cell.yaml", [](const fs::path& path) { read_cell(path); }}},
      {"cycles", {"cycles.csv", [](const fs::path& path) { read_cycles(path); }}},
      {"truth", {"truth.yaml", [](const fs::path& path) { read_truth(path); }}},
      {"camera", {"camera.yaml", [](const fs::path& path) { read_camera(path); }}},
      {"camera_xml", {"camera.xml", [](const fs::path& path) { read_camera(path); }}},
      {"workplane", {"workplane.yaml", [](const fs::path& path) { read_workplane(path); }}},
      {"tool", {"tool.yaml", [](const fs::path& path) { read_tool(path); }}},
      {"arm", {"arm.yaml", [](const fs::path& path) { read_found_arm(path); }}},
      {"arm_learned", {"arm_learned.yaml", [](const fs::path& path) { read_learned_arm(path); }}},
      {"arm_samples", {"samples.csv", [](const fs::path& path) { read_arm_samples(path); }}},
      {"modbus", {"drivers.yaml", [](const fs::path& path) { read_modbus_map(path); }}},
      {"tool_tip", {"needle.yaml", [](const fs::path& path) { read_tool_tip(path); }}},
      {"work", {"work.yaml", [](const fs::path& path) { read_works(path); }}},
      {"work_drawing", {"work.csv", [](const fs::path& path) { read_work_drawing(path); }}},
      {"map", {"map.yaml", [](const fs::path& path) { read_map(path); }}},
      {"frames", {"frames.csv", [](const fs::path& path) { read_frames(path.parent_path()); }}},
      {"lamps", {"lamps.csv", [](const fs::path& path) { read_lamps(path); }}},
      {"lays", {"lays.csv", [](const fs::path& path) { read_lays(path); }}},
      {"pairs", {"pairs.csv", [](const fs::path& path) { read_pairs(path); }}},
      {"path", {"path.csv", [](const fs::path& path) { read_path(path, 0.0); }}},
      {"plan", {"plan.csv", [](const fs::path& path) { read_plan(path, 0.0); }}},
      {"dxf", {"part.dxf", read_drawn}},
      {"gcode", {"part.nc", read_drawn}},
      {"results", {"results.csv", [](const fs::path& path) { read_results(path); }}},
      {"targets", {"targets.csv", [](const fs::path& path) { read_targets(path); }}},
      {"tracker", {"tracker.csv", [](const fs::path& path) { read_tracker(path, {}); }}},
      {"tracker_stream", {"stream.txt", read_tracker_stream}},
      {"stream", {"stream.csv", read_stream}},
      {"grbl", {"grbl.txt", read_board_lines}},
      {"board_points", {"points.txt", [](const fs::path& path) { read_board_pixels(path); }}},
      {"origins", {"map.yaml", [](const fs::path& path) { read_origins(path); }}},
      {"image", {"image.png", [](const fs::path& path) { read_grey_image(path); }}}};
  return all;
}

const Reader& reader() {
  static const Reader& chosen = []() -> const Reader& {
    const char* name = std::getenv("PLANAR_READER");
    const auto found = readers().find(name == nullptr ? "" : name);
    if (found != readers().end()) return found->second;
    std::cerr << "PLANAR_READER must be one of:";
    for (const auto& [known, unused] : readers()) std::cerr << ' ' << known;
    std::cerr << std::endl;
    std::exit(2);
  }();
  return chosen;
}

}  // namespace
}  // namespace planar

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer looks for this name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file = std::filesystem::absolute(planar::reader().file);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    planar::reader().read(file);
  } catch (const planar::InputError&) {
  }
  return 0;
}
