#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "planar_servo/core/units.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/offline/map/check_error_map.h"
#include "planar_servo/report/progress_bar.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-check-error-map",
                        "Judges an error map on pairs that it was not fitted to.",
                        "planar-check-error-map [--plan NAME[,NAME]] map.yaml pairs.csv",
                        R"(pairs               200 (0 outside the map's valid region)
                    mean      rms       95 %      max       mm
vision error        0.0893    0.2200    0.1018    2.9131
with the map        0.0214    0.2125    0.0116    3.0039
accuracy            A1 76.0 %, A2 83.8 %
within 95 %         99.5 %)"};

struct Options {
  std::vector<std::string> plans;
  std::filesystem::path map;
  std::filesystem::path pairs;
};

void print_row(const char* name, const Summary& summary) {
  fmt::print("{:<20}{:<10.4f}{:<10.4f}{:<10.4f}{:.4f}\n", name, summary.mean / kMillimetre,
             summary.rms / kMillimetre, summary.p95 / kMillimetre, summary.max / kMillimetre);
}

void print(const MapCheck& check, std::size_t n_left_out) {
  if (n_left_out > 0) fmt::print("left out            {} pairs of other plans\n", n_left_out);
  fmt::print("pairs               {} ({} outside the map's valid region)\n", check.raw.n,
             check.n_outside);
  fmt::print("{:<20}{:<10}{:<10}{:<10}{:<10}mm\n", "", "mean", "rms", "95 %", "max");
  print_row("vision error", check.raw);
  print_row("with the map", check.compensated);
  fmt::print("accuracy            A1 {:.1f} %, A2 {:.1f} %\n", 100.0 * check.a1, 100.0 * check.a2);
  if (std::isfinite(check.coverage_95))
    fmt::print("within 95 %         {:.1f} %\n", 100.0 * check.coverage_95);
}

nlohmann::json figures(const MapCheck& check) {
  return {{"n", check.raw.n},
          {"n_outside", check.n_outside},
          {"raw_mean_mm", check.raw.mean / kMillimetre},
          {"raw_rms_mm", check.raw.rms / kMillimetre},
          {"mean_mm", check.compensated.mean / kMillimetre},
          {"rms_mm", check.compensated.rms / kMillimetre},
          {"p95_mm", check.compensated.p95 / kMillimetre},
          {"max_mm", check.compensated.max / kMillimetre},
          {"a1", check.a1},
          {"a2", check.a2},
          {"coverage_95", check.coverage_95}};
}

MapCheck check(const ErrorMap& map, const std::vector<PairRow>& pairs) {
  ProgressBar bar;
  return check_error_map(map, pairs,
                         [&](const char* phase, double share) { bar.show(phase, share); });
}

Outcome check_pairs(const Options& options) {
  const ErrorMap map = read_map(options.map);
  std::vector<PairRow> all = read_pairs(options.pairs);
  const std::size_t count = all.size();
  const std::vector<PairRow> pairs = pairs_to_check(std::move(all), options.plans);
  require_directions(map, pairs, options.pairs);
  const MapCheck result = check(map, pairs);
  print(result, count - pairs.size());
  return {figures(result)};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--plan", options.plans, "only pairs of these plans (else: all but train)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME");
  app.add_option("map", options.map, "the map")->required()->type_name("map.yaml");
  app.add_option("pairs", options.pairs, "the pairs")->required()->type_name("pairs.csv");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::check_pairs);
}
