#include <fmt/format.h>

#include <cstdint>
#include <filesystem>

#include "app/paper_cell.h"
#include "core/error.h"
#include "program.h"
#include "text/atomic_file.h"
#include "text/growing_file.h"
#include "virtual_cell/truth.h"
#include "virtual_cell/truth_file.h"

namespace {

namespace fs = std::filesystem;

const planar::ProgramText kText{
    "planar-virtual-cell", "Makes virtual cells.",
    "planar-virtual-cell draw --seed N [--like paper] -o DIR",
    "  drew cell 7: cells/7/cell.yaml and its truth, cells/7/truth.yaml"};

planar::Outcome draw(std::uint32_t seed, const fs::path& folder) {
  const fs::path cell = folder / "cell.yaml", truth = folder / "truth.yaml";
  for (const fs::path& path : {cell, truth})
    if (fs::exists(path))
      throw planar::InputError(path.string() + ": is there already; name another folder");
  planar::make_folder(folder);
  planar::write_truth(truth, planar::draw_truth(seed));
  planar::write_file(cell, planar::paper_cell_text());
  fmt::print("drew cell {}: {} and its truth, {}\n", seed, cell.string(), truth.string());
  return {{{"seed", seed}, {"cell", cell.string()}, {"truth", truth.string()}}};
}

}  // namespace

int main(int argc, char** argv) {
  std::uint32_t seed = 0;
  std::string like = "paper";
  fs::path folder;
  const auto options = [&](CLI::App& app) {
    app.require_subcommand(1);
    app.fallthrough();
    CLI::App* command =
        app.add_subcommand("draw", "a new random cell of the same kind, with its truth");
    command->add_option("--seed", seed, "the same seed draws the same cell")->required();
    command->add_option("--like", like, "the kind of cell")->check(CLI::IsMember({"paper"}));
    command->add_option("-o,--out", folder, "folder for cell.yaml and truth.yaml")
        ->required()
        ->type_name("DIR");
  };
  return planar::run_program(kText, argc, argv, options, [&] { return draw(seed, folder); });
}
