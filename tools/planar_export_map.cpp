#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/map/export_map.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-export-map",
    "planar-export-map --format grid-csv|numpy|opencv-remap [--phi-deg PHI] [--step-mm S]\n"
    "                         [--cell cell.yaml] -o FILE map.yaml",
    R"(map                 gaussian_rbf
format              grid-csv
grid                154 x 152 nodes, 7.8 mm apart, 16038 valid
nodes               places as seen; compensated = seen - error
deviation           0.0016 mm at least, 0.0029 mm median per axis
interpolation       0.00015 mm at most, 8.8 % of the deviation there at most
read by             planar-fit-error-map -o map.yaml FILE)"};

struct Options {
  std::string format;
  std::optional<double> phi_deg, step_mm;
  std::filesystem::path output, cell, map;
  bool accept_map{false};
};

std::optional<double> in_si(const std::optional<double>& value, double unit) {
  return value ? std::optional(*value * unit) : std::nullopt;
}

Outcome write(const Options& options) {
  for (const std::filesystem::path& input : {options.map, options.cell})
    if (!input.empty()) require_not_input(options.output, input);
  require_writable(options.output, kErrorGridKind);
  ExportRequest request;
  request.map = options.map;
  if (!options.cell.empty()) request.cell = read_cell(options.cell);
  request.format = value_named(kGridFormats, options.format).value();
  if (request.format == GridFormat::kNumpy && options.output.extension() == ".npz")
    throw InputError({"names an archive of arrays, and this format is one array", "name it .npy",
                      options.output});
  request.phi = in_si(options.phi_deg, kDegree);
  request.step = in_si(options.step_mm, kMillimetre);
  request.accept_map = options.accept_map;
  const ExportedMap exported = export_map(request);
  write_file(options.output, exported.text);
  return told(exported_map_list(exported));
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--format", options.format, "FORMAT", "the format, by who reads it")
      ->check(CLI::IsMember(names_of(kGridFormats)));
  add_required(app, "-o,--out", options.output, "FILE", "the file to write");
  add_value(app, "--phi-deg", options.phi_deg, "PHI",
            "the tool's direction, for a map that depends on it")
      ->check(within(-360.0, 360.0));
  add_value(app, "--step-mm", options.step_mm, "S",
            "the distance between nodes, such as a picture's pixel; by default the largest that "
            "costs less than a tenth of the map's deviation")
      ->check(within(1e-3, 1e3));
  add_value(app, "--cell", options.cell, "cell.yaml",
            "the cell of a map that was fitted with --cell");
  app.add_flag("--accept-map", options.accept_map, "export even a map that its own fit rejects");
  add_required(app, "map", options.map, "map.yaml", "the map");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::write);
}
