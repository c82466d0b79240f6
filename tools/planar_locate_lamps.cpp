#include <spdlog/spdlog.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/lamps_report.h"
#include "planar_servo/offline/locate_lamps.h"
#include "planar_servo/offline/pairs/pair_files.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-locate-lamps",
    "planar-locate-lamps [--cell cell.yaml] [--lamps 1|2] [--centre METHOD] [--start U,V] "
    "[--report FILE.html|none] -o lamps.csv RECORDING | IMAGE...",
    "images              163: 156 ok, 7 board_view\n"
    "time                0.46 ms per image\n"
    "direction           known to 0.0034 deg"};

struct Options {
  fs::path cell, out;
  std::vector<fs::path> inputs;
  std::string method;         ///< empty: the cell's lamps.method, or auto without a cell
  std::vector<double> start;  ///< a pixel; empty where none is given
  std::string report;
  int lamps{2};
};

void add_options(CLI::App& app, Options& options) {
  add_value(app, "--cell", options.cell, "cell.yaml",
            "the cell; without it images may have any size and only pixels are written");
  app.add_option("--lamps", options.lamps, "lamps in view; 1 follows one disc through the images")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  app.add_option("--centre", options.method,
                 "how a lamp's centre is measured; by default the cell's lamps.method or auto; "
                 "fast suits even lamps only, canny-kasa is the paper's way")
      ->check(CLI::IsMember(names_of(kCenterMethods)));
  add_value(app, "--start", options.start, "U,V", "pixel of the disc in the first image")
      ->delimiter(',')
      ->expected(2)
      ->allow_extra_args(false)
      ->check(within(0.0, 1e5));
  add_required(app, "-o,--out", options.out, "lamps.csv", "the table to write");
  add_report_option(app, options.report);
  add_required(app, "images", options.inputs, "RECORDING|IMAGE",
               "a recording's folder, or images in their order");
}

/// Checks that all inputs exist. The parser cannot do it: it would take the value of a misspelt
/// option for an image.
void require_inputs(const std::vector<fs::path>& inputs) {
  Faults faults;
  for (const fs::path& input : inputs)
    if (!fs::exists(input))
      faults.add(
          {"does not exist", "a recording's folder or images are needed", input, Cause::kMissing});
  faults.throw_if_any();
}

/// Returns the folder when the input is a recording.
std::optional<fs::path> recording_of(const Options& options) {
  for (const fs::path& input : options.inputs) {
    if (!fs::is_directory(input)) continue;
    if (options.inputs.size() > 1)
      throw InputError({"is a folder", "give one recording, or images", input});
    if (options.lamps == 1)
      throw InputError({"a recording shows two lamps", "--lamps 1 takes images", input});
    return input;
  }
  return std::nullopt;
}

struct LocateJob {
  LocateRequest request;
  std::vector<Origin> origins;  ///< of the table; none without a cell
};

LocateJob read_job(const Options& options) {
  if (!options.start.empty() && options.lamps != 1)
    throw InputError(
        Refusal{"--start picks the disc that --lamps 1 follows", "two lamps need no start"});
  require_writable(options.out, "lamps");
  require_inputs(options.inputs);
  LocateJob job;
  LocateRequest& request = job.request;
  const std::optional<fs::path> recording = recording_of(options);
  const fs::path frames = recording ? *recording / "frames.csv" : fs::path();
  std::vector<fs::path> tables;
  std::optional<PlanarArm> arm;
  if (!options.cell.empty()) {
    const CellSettings cell = read_cell(options.cell);
    tables = {options.cell, cell.camera_model, cell.workplane, cell.tool};
    arm.emplace(cell.arm.geometry);
    request.method = cell.lamps.method;
    request.scene = read_lamp_scene(cell);
    for (const StaleFile& stale : stale_files(cell, false)) {
      spdlog::warn(stale.text() + "; until then lamps are located without the workplane");
      request.scene->vision.reset();
    }
    job.origins = origins_of_lamps(cell, frames, request.scene->vision.has_value());
  }
  if (!options.method.empty()) request.method = *value_named(kCenterMethods, options.method);
  request.images = recording ? images_of_recording(*recording, read_frames(*recording), arm)
                             : single_images(options.inputs);
  if (recording) tables.push_back(frames);
  for (const fs::path& table : tables) require_not_input(options.out, table);
  for (const LampImage& image : request.images) require_not_input(options.out, image.file);
  return job;
}

Outcome locate(const Options& options) {
  const auto page = page_for(options.report, options.out);
  auto [request, origins] = read_job(options);
  std::optional<ProgressBar> bar("locating");
  request.progress = [&](std::size_t done, std::size_t all) { bar->show(done, all); };
  std::optional<Eigen::Vector2d> start;
  if (!options.start.empty()) start.emplace(options.start[0], options.start[1]);
  const LocateReport report =
      options.lamps == 1 ? follow_disc(request, start) : locate_lamps(request);
  bar.reset();
  write_file(options.out, lamps_text(report.rows, lamp_remarks(origins, report.reference_lamps)));
  Outcome outcome = told(locate_list(report));
  if (page)
    write_page(*page,
               lamps_page(report, options.out,
                          request.scene ? std::optional(request.scene->sensor_px) : std::nullopt));
  if (request.scene)
    if (const auto doubt = distance_doubt(report, request.scene->lamps.separation_m))
      spdlog::warn(doubt->text());
  outcome.success = shows_any(report);
  if (!outcome.success)
    spdlog::error(fmt::format("no image shows what was looked for; {} says why for each",
                              options.out.string()));
  return outcome;
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::locate);
}
