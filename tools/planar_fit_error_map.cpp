#include <fmt/format.h>

#include <cmath>

#include "app/fit_error_map.h"
#include "core/units.h"
#include "files/map_file.h"
#include "program.h"
#include "text/atomic_file.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-fit-error-map",
    "Fits a map of the vision error to pairs of vision and tracker positions.",
    "planar-fit-error-map [--method auto|rbf|idw|hand:WIDTH_MM] -o map.yaml pairs.csv",
    R"(pairs used          196 (4 rejected)
  r32c56: 0.5229 mm from what the other pairs predict there, where 0.0816 mm is allowed
  r39c52: 499.9969 mm from what the other pairs predict there, where 0.0693 mm is allowed
  r46c6: 19.9811 mm from what the other pairs predict there, where 0.0752 mm is allowed
  r2c30: 3.0025 mm from what the other pairs predict there, where 0.0746 mm is allowed
method              multiquadric
vision error        0.0974 mm rms
leave-one-out       0.0236 mm rms (inverse distance weighting: 0.0424 mm)
noise               0.0126 mm per axis
gain                75.8 %, worth using)"};

struct Options {
  std::string method{"auto"};
  std::filesystem::path output;
  std::filesystem::path pairs;
};

void print(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  if (report.n_other_plans > 0)
    fmt::print("left for checking   {} pairs whose plan is not train\n", report.n_other_plans);
  fmt::print("pairs used          {} ({} rejected)\n", result.n_used, result.rejected.size());
  for (const RejectedSample& sample : result.rejected)
    fmt::print("  {}: {}\n", sample.id, sample.reason);
  fmt::print("method              {}\n", result.method);
  fmt::print("vision error        {:.4f} mm rms\n", result.raw_rms / kMillimetre);
  fmt::print("leave-one-out       {:.4f} mm rms", result.loo_rms / kMillimetre);
  if (result.method != "idw" && std::isfinite(result.idw_loo_rms))
    fmt::print(" (inverse distance weighting: {:.4f} mm)", result.idw_loo_rms / kMillimetre);
  fmt::print("\n");
  if (std::isfinite(result.noise_sigma))
    fmt::print("noise               {:.4f} mm per axis\n", result.noise_sigma / kMillimetre);
  fmt::print("gain                {:.1f} %, {}\n", 100.0 * result.gain(),
             result.worth_using ? "worth using" : "NOT significant: do not use this map");
}

nlohmann::json figures(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  nlohmann::json rejected = nlohmann::json::array();
  for (const RejectedSample& sample : result.rejected)
    rejected.push_back({{"id", sample.id},
                        {"residual_mm", sample.residual / kMillimetre},
                        {"reason", sample.reason}});
  return {{"n_used", result.n_used},
          {"n_rejected", result.rejected.size()},
          {"rejected", rejected},
          {"method", result.method},
          {"raw_rms_mm", result.raw_rms / kMillimetre},
          {"loo_rms_mm", result.loo_rms / kMillimetre},
          {"idw_loo_rms_mm", result.idw_loo_rms / kMillimetre},
          {"noise_mm", result.noise_sigma / kMillimetre},
          {"gain", result.gain()},
          {"worth_using", result.worth_using},
          {"n_other_plans", report.n_other_plans},
          {"fit_seconds", report.fit_seconds}};
}

Outcome fit(const Options& options) {
  require_not_input(options.output, options.pairs);
  const FitErrorMapReport report =
      fit_error_map_to_pairs(read_pairs(options.pairs), parse_map_method(options.method));
  write_file(options.output, map_text(report.result, options.pairs, kText.name));
  print(report);
  return {figures(report)};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--method", options.method,
                 "auto (by leave-one-out error), rbf (one Gaussian width), idw, or hand:WIDTH_MM "
                 "(the paper's Gaussian)")
      ->type_name("METHOD")
      ->capture_default_str();
  app.add_option("-o,--output", options.output, "the map to write")
      ->required()
      ->type_name("map.yaml");
  app.add_option("pairs", options.pairs, "the pairs")->required()->type_name("pairs.csv");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::fit);
}
