#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>

#include "planar_servo/core/error.h"
#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/experiment/paper_cell.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/virtual_kinds.h"
#include "planar_servo/served_cell/serve_cell.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const CommandText kDraw{"draw",
                        "planar-virtual-cell draw --seed N [--like paper|rough|workshop] -o DIR",
                        "drew cell 7: cells/7/cell.yaml and its truth, cells/7/truth.yaml"};

using Draw = Truth (*)(std::uint32_t seed);
constexpr Named<Draw> kKinds[] = {
    {draw_truth, "paper"}, {draw_rough_truth, "rough"}, {draw_workshop_truth, "workshop"}};

const CommandText kServe{
    "serve", "planar-virtual-cell serve --cell cell.yaml [--address ADDRESS]",
    "serving cell.yaml as a GigE Vision camera on 127.0.0.1 until interrupted"};
const ProgramText kText{"planar-virtual-cell",
                        "Makes virtual cells, and serves their cameras.",
                        kDraw.synopsis + "\n       " + kServe.synopsis,
                        kDraw.sample,
                        {kDraw, kServe}};

struct Options {
  std::uint32_t seed{0};
  std::string like{"paper"};
  fs::path folder;
  fs::path cell;
  std::string address{"127.0.0.1"};
};

/// Names the reference lamps of a workshop's cell file, with the diameter of the tool's.
std::string reference_lamps_text() {
  std::string text = "reference_lamps:\n";
  for (const StatedLamp& lamp : workshop_lamps())
    text +=
        fmt::format("  - {{id: {}, diameter_mm: 8.0, x_mm: {}, y_mm: {}}}\n", lamp.id,
                    std::round(lamp.p_B.x() / kMillimetre), std::round(lamp.p_B.y() / kMillimetre));
  return text;
}

Outcome draw(const Options& options) {
  const Draw draw_truth_like = value_named(kKinds, options.like).value();
  const fs::path cell = options.folder / "cell.yaml", truth = options.folder / "truth.yaml";
  for (const fs::path& path : {cell, truth})
    if (fs::exists(path)) throw InputError(path.string() + ": exists already; name another folder");
  make_folder(options.folder);
  write_file(cell,
             paper_cell_text() +
                 (draw_truth_like == draw_workshop_truth ? reference_lamps_text() : std::string()));
  Truth drawn = draw_truth_like(options.seed);
  drawn.build = build_as_stated(virtual_hardware(read_cell(cell)));
  write_truth(truth, drawn);
  fmt::print("drew cell {}: {} and its truth, {}\n", options.seed, cell.string(), truth.string());
  return {{{"seed", options.seed}, {"cell", cell.string()}, {"truth", truth.string()}}};
}

Outcome serve(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  heed_interrupts();
  const auto started = [&] {
    fmt::print("serving {} as a GigE Vision camera on {} until interrupted\n",
               options.cell.string(), options.address);
    std::fflush(stdout);
  };
  serve_cell(cell, options.address, started, interrupted);
  return {};
}

Outcome work(const Options& options) {
  return options.cell.empty() ? draw(options) : serve(options);
}

void add_options(CLI::App& app, Options& options) {
  app.require_subcommand(1);
  app.fallthrough();
  CLI::App* server = app.add_subcommand(
      kServe.name, "Serves a cell's camera as a GigE Vision camera of this machine.");
  server->add_option("--cell", options.cell, "the virtual cell")->required()->type_name("FILE");
  server->add_option("--address", options.address, "an address of this machine")
      ->capture_default_str();
  CLI::App* command = app.add_subcommand(kDraw.name, "Draws a new random cell with its truth.");
  command->add_option("--seed", options.seed, "the same seed draws the same cell")->required();
  command
      ->add_option("--like", options.like,
                   "the kind of cell: the paper's; one whose arm and readings have what the "
                   "estimators' models lack; one that warms, with fixed lamps")
      ->check(CLI::IsMember(names_of(kKinds)))
      ->capture_default_str();
  command->add_option("-o,--out", options.folder, "folder for cell.yaml and truth.yaml")
      ->required()
      ->type_name("DIR");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
