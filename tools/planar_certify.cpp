#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "homing_options.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/certificate/certificate_report.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-certify",
    "planar-certify --cell cell.yaml --out DIR [--cycles N] [--targets N] [--home] [--at-marks]\n"
    "                      [--accept-stale] [--accept-map]",
    R"(moves               610 of 610 moves reached and judged by the truth
pose accuracy       0.0250 mm AP at P4, the worst of 5
repeatability       0.0062 mm RP at P4, over 30 cycles
from 4 directions   0.0011 mm vAP at P4; scatter alone keeps it below 0.0014 mm
drift               0.0017 mm between the first and last thirds; chance alone keeps it below 0.0009 mm
whole workspace     0.0136 mm mean, 0.0153 rms, 0.0253 at 95 %, 0.0355 max at 100 targets
budget              0.0095 mm rms expected, 0.0153 found; field: error map weighs most
certificate: DIR/certificate.html)"};

struct Options {
  std::filesystem::path cell;
  CertificateRequest request;
  HomingOptions homing;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the calibrated cell");
  add_required(app, "--out", options.request.servo.folder.path, "DIR",
               "folder for the page, the figures and every cycle; the same command continues a "
               "run that was broken off");
  app.add_option("--cycles", options.request.size.cycles,
                 "cycles of the five poses, and of the directions of approach; the standard has 30")
      ->check(CLI::Range(CertificateSize::kLeastCycles, CertificateSize::kMostCycles))
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--targets", options.request.size.targets,
                 "targets over the whole workspace; with fewer than 72 the 95 % have no interval")
      ->check(CLI::Range(1, CertificateSize::kMostTargets))
      ->type_name("N")
      ->capture_default_str();
  add_homing_options(app, options.homing);
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

Outcome certify(const Options& options) {
  const CertificateRequest request = request_of(options);
  heed_interrupts();
  ProgressBar bar("moves");
  const Certificate certificate = certificate_of(run_certificate(
      request, open_cell, [&](std::size_t done, std::size_t all) { bar.show(done, all); }));
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
