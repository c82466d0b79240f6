#include <spdlog/spdlog.h>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/learn/error_map/compare_methods.h"
#include "planar_servo/learn/error_map/fit/pair_checks.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/map/learn_lamp_field.h"
#include "planar_servo/offline/map/map_report.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-fit-error-map",
    "planar-fit-error-map [--method auto|rbf|idw|hand:WIDTH_MM] [--report FILE.html|none]\n"
    "                            -o map.yaml pairs.csv\n"
    "       planar-fit-error-map --cell cell.yaml [--lays lays.csv] [--bar bar.csv] [--marks "
    "marks.csv]\n"
    "                            [--image FILE...] [--arm-out arm.yaml] [--report FILE.html|none]\n"
    "                            -o map.yaml pairs.csv",
    R"(pairs used          199 (1 rejected)
  p17: 3.0047 mm from what the other pairs predict there, where 0.0276 mm is allowed
method              gaussian_rbf
vision error        0.0775 mm rms
leave-one-out       0.0097 mm rms
noise               0.0059 mm per axis
gain                87.4 %, worth using

Faults of the cell
  fault                     value  rms over the field, mm  significant
  shift x   0.001134 +- 0.0128 mm                  0.0011

Methods, compared at places left out
  method  one place, mm rms  a block of neighbours, mm rms  its 95 % interval, mm
  raw                0.0775                         0.0775       0.0740 to 0.0812
  auto               0.0097                         0.0148       0.0111 to 0.0197)"};

struct Options {
  std::string method{"auto"}, report;
  LampFieldFiles files;
  std::filesystem::path cell;
  double bar_sigma_mm{0.005}, marks_sigma_mm{0.02};
  std::vector<std::filesystem::path> images;
};

struct Fitted {
  FitErrorMapReport report;
  std::optional<Refusal> doubt;
  std::vector<MethodFigures> comparison;
};

Fitted fit_and_compare(const std::filesystem::path& file, const MapMethodChoice& choice) {
  ProgressBar bar;
  const Progress progress = [&](const char* phase, double share) { bar.show(phase, share); };
  const TrainingPairs pairs = read_training_pairs(file, choice);
  FitErrorMapReport report = fit_error_map_to_pairs(pairs, progress);
  std::vector<MethodFigures> comparison = compare_methods(pairs.problem, report.result, progress);
  return {std::move(report), doubt_of_shared_error(pairs.problem.samples), std::move(comparison)};
}

/// Says what speaks against the map that was written.
void warn_of(const std::optional<Refusal>& objection, const std::filesystem::path& map) {
  if (objection)
    spdlog::warn("{} is written, but {}; planar-servo refuses it without --accept-map",
                 map.string(), objection->fault);
}

/// Learns the error at the lamps together with the arm.
Outcome fit_with_cell(const Options& options, const std::optional<std::filesystem::path>& page) {
  LampFieldFiles files = options.files;
  files.bar_sigma = options.bar_sigma_mm * kMillimetre;
  files.marks_sigma = options.marks_sigma_mm * kMillimetre;
  const CellSettings cell = read_cell(options.cell);
  for (const std::filesystem::path& image : options.images)
    files.pictures.emplace_back([image, &cell] { return saved_frames({image}, cell); });
  const VisionCalibration vision = read_vision(cell, false);
  require_belonging(contradictions(files.inputs(), origins_in(cell, calibration_files(cell, false)),
                                   values_of(kRoles)));
  const SteadyClock clock;
  const double begin_s = clock.now_s();
  std::optional<ProgressBar> bar(std::in_place);
  const LampFieldFit fit = learn_lamp_field(
      files, cell, vision, [&](const char* phase, double share) { bar->show(phase, share); });
  bar.reset();
  const double fit_seconds = clock.now_s() - begin_s;
  write_lamp_field(files, fit, cell, kText.name);
  warn_of(objection(fit.quality()), files.map);
  ReportList list = lamp_field_list(fit);
  list.unprinted("fit_seconds", fit_seconds);
  say("{}", list.text());
  if (page) write_page(*page, map_page(view_of(fit, list), files.map));
  return {list.json()};
}

Outcome fit(const Options& options) {
  std::vector<std::filesystem::path> inputs;
  const LampFieldFiles& files = options.files;
  for (const MadeFile& input : files.inputs()) inputs.push_back(input.path);
  require_outputs({{files.map, "map"}, {files.arm, "arm"}}, inputs);
  const auto page = page_for(options.report, files.map);
  if ((files.bar.empty() && files.marks.empty()) != options.images.empty())
    throw InputError(Refusal{"--bar and --marks need pictures, and --image one of them",
                             "give whole pictures that show them, such as planar-record --bar "
                             "takes"});
  if (!options.cell.empty()) return fit_with_cell(options, page);
  const MapMethodChoice choice = parse_map_method(options.method);
  const auto [report, doubt, comparison] = fit_and_compare(files.pairs, choice);
  write_file(files.map, map_text(report.result, files.pairs, kText.name));
  if (doubt) spdlog::warn(doubt->text());
  warn_of(objection(report.result.quality()), files.map);
  const ReportList list = map_fit_list(report, comparison);
  say("{}", list.text());
  if (page) write_page(*page, map_page(view_of(report, list), files.map));
  return {list.json()};
}

void add_options(CLI::App& app, Options& options) {
  CLI::Option* method =
      add_default(app, "--method", options.method, "auto|rbf|idw|hand:WIDTH_MM",
                  "how a map at the end point is fitted: auto by leave-one-out error, rbf with one "
                  "Gaussian width, idw by distances, hand with the paper's Gaussian");
  CLI::Option* cell =
      add_value(app, "--cell", options.cell, "cell.yaml",
                "the cell: learn the error at the lamps together with its arm, from readings "
                "and from poses without one")
          ->excludes(method);
  add_value(app, "--lays", options.files.lays, "lays.csv",
            "dots of a board laid on the plane, by planar-pair-tracker --lays-out: they give "
            "the field's shape and, with a known pitch, its scale")
      ->needs(cell);
  CLI::Option* bar =
      add_value(app, "--bar", options.files.bar, "bar.csv",
                "the two marks of a bar of certified length, as work.csv has them: its "
                "pictures give the scale")
          ->needs(cell);
  add_default(app, "--bar-sigma-mm", options.bar_sigma_mm, "S",
              "standard deviation of its length, its growth by warmth included")
      ->needs(bar)
      ->check(CLI::PositiveNumber);
  CLI::Option* marks =
      add_value(app, "--marks", options.files.marks, "marks.csv",
                "marks of the base at their places in its frame, as work.csv has them: they "
                "give datum and turn")
          ->needs(cell);
  add_default(app, "--marks-sigma-mm", options.marks_sigma_mm, "S",
              "standard deviation of such a place per axis")
      ->needs(marks)
      ->check(CLI::PositiveNumber);
  add_value(app, "--image", options.images, "FILE",
            "whole pictures of the bar and of the base's marks");
  add_value(app, "--arm-out", options.files.arm, "arm.yaml", "the arm that was found")->needs(cell);
  add_report_option(app, options.report);
  add_required(app, "-o,--out", options.files.map, "map.yaml", "the map to write");
  add_required(app, "pairs", options.files.pairs, "pairs.csv", "the pairs");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::fit);
}
