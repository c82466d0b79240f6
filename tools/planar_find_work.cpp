#include <spdlog/spdlog.h>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/work/workpiece/work_page.h"
#include "planar_servo/work/workpiece/work_watch.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-find-work",
    "planar-find-work --cell cell.yaml --drawing work.csv -o work.yaml [--near X,Y[,TURN]]\n"
    "                     [--within MM] [--map rigid|similarity|affine] [--all]\n"
    "                     [--drawing-sigma-mm S] [--exposure-ms T] [--frames N] [--image FILE "
    "...]\n"
    "                     [--no-error-map] [--accept-stale] [--report FILE.html|none]",
    R"(works               1
origin              (187.352, 241.018) mm
turned by           12.0034 deg
marks               4, up to 0.0051 mm from the fit
deviation           0.0112 mm per axis at the marks)"};

struct Options {
  fs::path cell, drawing, out;
  std::vector<fs::path> images;
  std::vector<double> near;
  double within_mm{20.0}, drawing_sigma_mm{0.02}, exposure_ms{0.0};
  WorkMap map{WorkMap::kRigid};
  std::string report;
  int frames{5};
  bool all{false}, no_error_map{false}, accept_stale{false};
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell, calibrated");
  add_required(app, "--drawing", options.drawing, "work.csv",
               "the work's marks in its drawing: id, x_mm, y_mm, kind, size_mm[, z_mm, "
               "sigma_z_mm]; x right and y up, seen from above; z over the lamps' plane");
  add_required(app, "-o,--out", options.out, "work.yaml", "the file to write");
  auto* near = add_value(app, "--near", options.near, "X,Y[,TURN]",
                         "where the drawing's origin should be, and how it is turned, mm and "
                         "deg in the base frame; by default anywhere in the picture")
                   ->delimiter(',')
                   ->expected(2, 3);
  add_default(app, "--within", options.within_mm, "MM", "how far from there it may be")
      ->needs(near)
      ->check(CLI::PositiveNumber);
  add_choice(app, "--map", options.map, kWorkMaps,
             "the most the drawing may have changed: a similarity allows a shrunk print; two marks "
             "never give more than rigid");
  add_default(app, "--drawing-sigma-mm", options.drawing_sigma_mm, "S",
              "standard deviation of a mark about its drawing; 0.02 is that of an etched board "
              "or a milled plate")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--all", options.all, "keep every work of the drawing that is found, as on a panel");
  add_value(app, "--exposure-ms", options.exposure_ms, "T",
            "expose for so long, where the marks are darker than the lamps; by default as the "
            "camera is set")
      ->check(CLI::PositiveNumber);
  add_default(app, "--frames", options.frames, "N", "pictures to take")->check(CLI::Range(1, 100));
  add_value(app, "--image", options.images, "FILE",
            "whole pictures of the camera that were taken before, instead of new ones");
  app.add_flag("--no-error-map", options.no_error_map, "use vision without the error map");
  app.add_flag("--accept-stale", options.accept_stale,
               "use files that were not made from one another");
  add_report_option(app, options.report);
}

WorkSettings settings_of(const Options& options) {
  WorkSettings settings;
  settings.allowed = options.map;
  settings.drawing_sigma = options.drawing_sigma_mm * kMillimetre;
  settings.all = options.all;
  if (!options.near.empty())
    settings.place = WorkPlace{{Eigen::Vector2d(options.near[0], options.near[1]) * kMillimetre,
                                options.near.size() > 2 ? options.near[2] * kDegree : 0.0},
                               options.near.size() < 3,
                               options.within_mm * kMillimetre};
  return settings;
}

std::optional<double> exposure_of(const Options& options) {
  if (options.exposure_ms == 0.0) return std::nullopt;
  return options.exposure_ms * kMillisecond;
}

WorkFrames new_frames(const Options& options, const CellSettings& cell) {
  heed_interrupts();
  const auto devices = open_cell(cell);
  return frames_of_work(devices->camera(), options.frames, exposure_of(options));
}

Outcome find(const Options& options) {
  require_writable(options.out, "work");
  require_not_input(options.out, options.drawing);
  const auto page = page_for(options.report, options.out);
  const std::vector<Fiducial> drawing = read_work_drawing(options.drawing);
  const CellSettings settings = read_cell(options.cell);
  const CalibratedCell cell = read_calibrated_cell(settings, !options.no_error_map);
  require_calibrated(cell);
  accept_stale(cell.stale, options.accept_stale);
  const WorkFrames frames = options.images.empty()
                                ? new_frames(options, settings)
                                : WorkFrames{saved_frames(options.images, settings)};
  const std::vector<FoundWork> works =
      find_work(frames.of_marks, *cell.vision, drawing, settings_of(options), frames.of_lamps);
  for (const FoundWork& work : works)
    for (const std::string& remark : work.remarks)
      spdlog::warn((work.id.empty() ? "" : "work " + work.id + ": ") + remark);
  write_file(options.out,
             work_text({options.out, exposure_of(options), works},
                       work_origins(settings, options.drawing, uses_error_map(cell)), kText.name));
  Outcome outcome = told(work_list(works));
  if (page) write_page(*page, work_page(works, frames.of_marks.front().image, options.out));
  return outcome;
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::find);
}
