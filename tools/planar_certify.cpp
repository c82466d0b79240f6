#include <spdlog/spdlog.h>

#include "homing_options.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/certificate/certificate_report.h"
#include "planar_servo/certificate/scale_bar.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/work/workpiece/work_watch.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-certify",
    "planar-certify --cell cell.yaml --out DIR [--cycles N] [--targets N] [--home] [--at-marks]\n"
    "                      [--nearest-turn] [--accept-stale] [--accept-map]\n"
    "       planar-certify --cell cell.yaml --out DIR --by scale-bar --bar bar.csv\n"
    "                      [--bar-sigma-mm S] [--image FILE ...] [--accept-stale]",
    R"(moves               610 of 610 moves reached and judged by the truth
pose accuracy       0.0250 mm AP at P4, the worst of 5
repeatability       0.0062 mm RP at P4, over 30 cycles
from 4 directions   0.0011 mm vAP at P4; scatter alone keeps it below 0.0014 mm
drift               0.0017 mm between the first and last thirds; chance alone keeps it below 0.0009 mm
whole workspace     0.0136 mm mean, 0.0153 rms, 0.0253 at 95 %, 0.0355 max at 100 targets
budget              0.0095 mm rms expected, 0.0153 found; field: error map weighs most
certificate: DIR/certificate.html)"};

constexpr char kMoves[] = "moves", kScaleBar[] = "scale-bar";

struct Options {
  std::filesystem::path cell;
  CertificateRequest request;
  HomingOptions homing;
  std::string by{kMoves};
  std::filesystem::path bar;
  std::vector<std::filesystem::path> images;
  double bar_sigma_mm{0.005};
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the calibrated cell");
  add_required(app, "--out", options.request.servo.folder.path, "DIR",
               "folder for the page, the figures and every cycle; the same command continues a "
               "run that was broken off");
  add_default(app, "--cycles", options.request.size.cycles, "N",
              "cycles of the five poses, and of the directions of approach; the standard has 30")
      ->check(CLI::Range(CertificateSize::kLeastCycles, CertificateSize::kMostCycles));
  add_default(app, "--targets", options.request.size.targets, "N",
              "targets over the whole workspace; with fewer than 72 the 95 % have no interval")
      ->check(CLI::Range(1, CertificateSize::kMostTargets));
  add_homing_options(app, options.homing);
  add_choice(
      app, "--by", options.by, {kMoves, kScaleBar},
      "moves: of the arm, judged by truth or tracker; scale-bar: lengths that vision measures "
      "of a bar laid in seven places or more, with nothing moved");
  auto* bar = add_value(app, "--bar", options.bar, "bar.csv",
                        "the bar's two marks, as planar-find-work reads those of a work, at their "
                        "certified distance");
  add_default(app, "--bar-sigma-mm", options.bar_sigma_mm, "S",
              "standard deviation of that distance, its growth by warmth included")
      ->needs(bar)
      ->check(CLI::PositiveNumber);
  add_value(app, "--image", options.images, "FILE",
            "whole pictures of the bar that were taken before; else it is asked for at a terminal")
      ->needs(bar);
  app.add_flag("--accept-stale", options.request.servo.accepted.stale,
               "move even with files that were not made from one another; the page says which");
  app.add_flag("--accept-map", options.request.servo.accepted.map, kAcceptMap);
}

CertificateRequest request_of(const Options& options) {
  CertificateRequest request = options.request;
  const CellSettings cell = read_cell(options.cell);
  require_devices(cell);
  request.servo.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  request.servo.policy.center = cell.lamps.method;
  request.servo.may_home = may_home(options.homing);
  request.servo.stop = interrupted;
  return request;
}

/// Takes pictures of the bar, place by place, until the person says that it was the last. Without a
/// person there is one picture.
ScaleBarResult bar_by_camera(const CalibratedCell& cell, const ScaleBar& bar) {
  constexpr int kFrames = 3;
  heed_interrupts();
  const auto devices = open_cell(cell.settings);
  Terminal terminal;
  ScaleBarResult result{bar, {}};
  do {
    try {
      add_lengths(result, whole_frames(devices->camera(), kFrames, std::nullopt), *cell.vision);
      if (terminal.is_attended()) terminal.say(length_words(result.lengths.back()));
    } catch (const WorkError& e) {
      if (!terminal.is_attended()) throw;
      terminal.warn(e.what());
    }
  } while (terminal.is_attended() && !interrupted() &&
           terminal.ask(fmt::format("{} places; lay the bar elsewhere, then Enter, or end with q: ",
                                    result.places())) != "q");
  return result;
}

ScaleBarResult bar_in_pictures(const CalibratedCell& cell, const ScaleBar& bar,
                               const std::vector<std::filesystem::path>& images) {
  ScaleBarResult result{bar, {}};
  for (const std::filesystem::path& image : images) {
    const std::vector<Frame> frames = saved_frames({image}, cell.settings);
    try {
      add_lengths(result, frames, *cell.vision);
    } catch (const WorkError& e) {
      throw WorkError(e.refusal().at(image.string()));
    }
  }
  return result;
}

Outcome certify_by_bar(const Options& options) {
  const CellSettings settings = read_cell(options.cell);
  const CalibratedCell cell = read_calibrated_cell(settings);
  require_calibrated(cell);
  accept_stale(cell.stale, options.request.servo.accepted.stale);
  const ScaleBar bar = read_scale_bar(options.bar, options.bar_sigma_mm * kMillimetre);
  const std::filesystem::path page = options.request.servo.folder.path / "scale_bar.html";
  if (std::filesystem::exists(page))
    throw InputError({"exists already", "name another folder", page, Cause::kExists});
  make_folder(options.request.servo.folder.path);
  require_writable(page, "page");
  const ScaleBarResult result = options.images.empty() ? bar_by_camera(cell, bar)
                                                       : bar_in_pictures(cell, bar, options.images);
  const ReportList list = scale_bar_list(result);
  write_file(page, scale_bar_page(result, options.cell));
  say("{}certificate: {}\n", list.text(), page.string());
  const std::optional<Refusal> fault = result.fault();
  if (fault) spdlog::error(fault->text());
  return {list.json(), !fault};
}

Outcome certify(const Options& options) {
  if (options.by == kScaleBar) {
    if (options.bar.empty())
      throw InputError(Refusal{"--by scale-bar needs --bar", "name the table of its two marks"});
    return certify_by_bar(options);
  }
  if (!options.bar.empty())
    throw InputError(Refusal{"--bar needs --by scale-bar: without it the arm moves",
                             "add --by scale-bar, or leave --bar out"});
  const CertificateRequest request = request_of(options);
  heed_interrupts();
  std::optional<ProgressBar> bar("moves");
  const Certificate certificate = certificate_of(run_certificate(
      request, open_cell, [&](std::size_t done, std::size_t all) { bar->show(done, all); }));
  bar.reset();
  if (!certificate.run.ended_by.empty())
    spdlog::error(fmt::format(
        "{}; the cell is in doubt and no further move was made; mend it, then give the same "
        "command to continue",
        certificate.run.ended_by));
  write_certificate(certificate);
  const ReportList list = certificate_list(certificate);
  say("{}certificate: {}\n", list.text(),
      (request.servo.folder.path / "certificate.html").string());
  return {list.json(), certificate.all_count()};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::certify);
}
