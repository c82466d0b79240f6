#include <fmt/format.h>

#include <utility>

#include "planar_servo/error_map/judge/compare_methods.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/map/map_fit_report.h"
#include "planar_servo/report/progress_bar.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-fit-error-map",
    "Fits a map of the vision error to pairs of vision and tracker positions.",
    "planar-fit-error-map [--method auto|rbf|idw|hand:WIDTH_MM] -o map.yaml pairs.csv",
    R"(pairs used          196 (4 rejected)
  r4c36: 502.1426 mm from what the other pairs predict there, where 12.7453 mm is allowed
  r61c7: 20.0207 mm from what the other pairs predict there, where 0.0676 mm is allowed
  r16c23: 3.0087 mm from what the other pairs predict there, where 0.0879 mm is allowed
  r19c41: 0.5093 mm from what the other pairs predict there, where 0.0661 mm is allowed
method              multiquadric_rbf
vision error        0.0938 mm rms
leave-one-out       0.0250 mm rms
noise               0.0135 mm per axis
gain                73.3 %, worth using

what the pairs say of the cell                        rms, mm
shift x               -0.005289 +- 0.0108   mm       0.0053
shift y                 0.04751 +- 0.0126   mm       0.0475  significant
scale (plane height)      -1158 +- 416      um/m     0.0575
rotation                 -502.8 +- 228      urad     0.0249
x longer than y            1166 +- 470      um/m     0.0289
x, y not square          -328.6 +- 370      urad     0.0081
tilt towards x            8.427 +- 7.33     mrad/m   0.0156
tilt towards y           -8.032 +- 4.48     mrad/m   0.0186
radial remainder          198.1 +- 109      mm/m^3   0.0388
left by all of these                                 0.0707

rms, mm        left out: one   a block of neighbours (95 % interval)
raw                   0.0938     0.0938  (0.0764 to 0.1151)
idw                   0.0462     0.0631  (0.0512 to 0.0777)
hand:48                    -   its equations cannot be solved
rbf                   0.0259     0.0455  (0.0347 to 0.0595)
auto                  0.0250     0.0374  (0.0290 to 0.0481))"};

struct Options {
  std::string method{"auto"};
  std::filesystem::path output;
  std::filesystem::path pairs;
};

struct Fitted {
  FitErrorMapReport report;
  std::vector<MethodFigures> comparison;
};

Fitted fit_and_compare(const std::filesystem::path& file, const MapMethodChoice& choice) {
  ProgressBar bar;
  const Progress progress = [&](const char* phase, double share) { bar.show(phase, share); };
  const TrainingPairs pairs = read_training_pairs(file, choice);
  FitErrorMapReport report = fit_error_map_to_pairs(pairs, progress);
  std::vector<MethodFigures> comparison = compare_methods(pairs.problem, report.result, progress);
  return {std::move(report), std::move(comparison)};
}

Outcome fit(const Options& options) {
  require_writable(options.output);
  require_not_input(options.output, options.pairs);
  const MapMethodChoice choice = parse_map_method(options.method);
  const auto [report, comparison] = fit_and_compare(options.pairs, choice);
  write_file(options.output, map_text(report.result, options.pairs, kText.name));
  fmt::print("{}", map_fit_text(report, comparison));
  return {map_fit_json(report, comparison)};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--method", options.method,
                 "auto (by leave-one-out error), rbf (one Gaussian width), idw, or hand:WIDTH_MM "
                 "(the paper's Gaussian)")
      ->type_name("METHOD")
      ->capture_default_str();
  app.add_option("-o,--out", options.output, "the map to write")->required()->type_name("map.yaml");
  app.add_option("pairs", options.pairs, "the pairs")->required()->type_name("pairs.csv");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::fit);
}
