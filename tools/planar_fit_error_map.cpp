#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/judge/compare_methods.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/report/progress_bar.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-fit-error-map",
    "Fits a map of the vision error to pairs of vision and tracker positions.",
    "planar-fit-error-map [--method auto|rbf|idw|hand:WIDTH_MM] -o map.yaml pairs.csv",
    R"(pairs used          199 (1 rejected)
  p17: 3.0047 mm from what the other pairs predict there, where 0.0276 mm is allowed
method              rbf
vision error        0.0775 mm rms
leave-one-out       0.0097 mm rms
noise               0.0059 mm per axis
gain                87.4 %, worth using

what the pairs say of the cell                        rms, mm
shift x                0.001134 +- 0.0128   mm       0.0011

rms, mm        left out: one   a block of neighbours (95 % interval)
raw                   0.0775     0.0775  (0.0740 to 0.0812)
auto                  0.0097     0.0148  (0.0111 to 0.0197))"};

struct Options {
  std::string method{"auto"};
  std::filesystem::path output;
  std::filesystem::path pairs;
};

void print(const CellDiagnosis& cell) {
  if (cell.terms.empty()) return;
  fmt::print("\nwhat the pairs say of the cell                        rms, mm\n");
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    fmt::print("{:<20} {:>10.4g} +- {:<8.3g} {:<7} {:>7.4f}{}\n", name.label,
               term.value / name.unit, term.sigma / name.unit, name.unit_text,
               term.rms / kMillimetre, term.significant ? "  significant" : "");
  }
  fmt::print("left by all of these {:>38.4f}\n", cell.left_rms / kMillimetre);
}

void print(const std::vector<MethodFigures>& comparison) {
  fmt::print("\nrms, mm        left out: one   a block of neighbours (95 % interval)\n");
  for (const MethodFigures& method : comparison) {
    if (!std::isfinite(method.loo_rms)) {
      fmt::print("{:<14}             -   its equations cannot be solved\n", method.method);
      continue;
    }
    fmt::print("{:<14} {:>13.4f}   {:>8.4f}  ({:.4f} to {:.4f})\n", method.method,
               method.loo_rms / kMillimetre, method.blocked.value / kMillimetre,
               method.blocked.low / kMillimetre, method.blocked.high / kMillimetre);
  }
}

void print(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  if (report.n_other_plans > 0)
    fmt::print("left for checking   {} pairs whose plan is not train\n", report.n_other_plans);
  fmt::print("pairs used          {} ({} rejected)\n", result.n_used, result.rejected.size());
  for (const RejectedSample& sample : result.rejected)
    fmt::print("  {}: {}\n", sample.id, sample.reason);
  fmt::print("method              {}\n", result.method);
  fmt::print("vision error        {:.4f} mm rms\n", result.raw_rms / kMillimetre);
  fmt::print("leave-one-out       {:.4f} mm rms\n", result.loo_rms / kMillimetre);
  if (std::isfinite(result.noise_sigma))
    fmt::print("noise               {:.4f} mm per axis\n", result.noise_sigma / kMillimetre);
  if (const auto bias = tool_bias(result.map))
    fmt::print("in the tool's frame {} +- {:.4f} mm, used\n", fixed(bias->t / kMillimetre, 4, " "),
               bias->sigma / kMillimetre);
  fmt::print("gain                {} %, {}\n", fixed(100.0 * result.gain(), 1),
             result.worth_using ? "worth using" : "NOT significant: do not use this map");
}

nlohmann::json interval_mm(const RmsEstimate& estimate) {
  return {estimate.low / kMillimetre, estimate.high / kMillimetre};
}

nlohmann::json figures(const std::vector<MethodFigures>& comparison) {
  nlohmann::json rows = nlohmann::json::array();
  for (const MethodFigures& method : comparison) {
    rows.push_back({{"method", method.method},
                    {"loo_rms_mm", method.loo_rms / kMillimetre},
                    {"blocked_rms_mm", method.blocked.value / kMillimetre},
                    {"blocked_rms_95_mm", interval_mm(method.blocked)}});
  }
  return rows;
}

nlohmann::json figures(const CellDiagnosis& cell) {
  nlohmann::json terms = nlohmann::json::object();
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    terms[name.key] = {{"value", term.value / name.unit},
                       {"sigma", term.sigma / name.unit},
                       {"rms_mm", term.rms / kMillimetre},
                       {"significant", term.significant}};
  }
  return terms;
}

nlohmann::json figures(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  nlohmann::json rejected = nlohmann::json::array();
  for (const RejectedSample& sample : result.rejected)
    rejected.push_back({{"id", sample.id},
                        {"residual_mm", sample.residual / kMillimetre},
                        {"reason", sample.reason}});
  nlohmann::json keys{{"n_used", result.n_used},
                      {"n_rejected", result.rejected.size()},
                      {"rejected", rejected},
                      {"method", result.method},
                      {"raw_rms_mm", result.raw_rms / kMillimetre},
                      {"loo_rms_mm", result.loo_rms / kMillimetre},
                      {"idw_loo_rms_mm", result.idw_loo_rms / kMillimetre},
                      {"blocked_rms_mm", result.blocked.value / kMillimetre},
                      {"blocked_rms_95_mm", interval_mm(result.blocked)},
                      {"cell", figures(result.cell)},
                      {"noise_mm", result.noise_sigma / kMillimetre},
                      {"gain", result.gain()},
                      {"worth_using", result.worth_using},
                      {"n_other_plans", report.n_other_plans},
                      {"fit_seconds", report.fit_seconds}};
  if (const auto bias = tool_bias(result.map)) {
    keys["tool_bias_mm"] = {bias->t.x() / kMillimetre, bias->t.y() / kMillimetre};
    keys["tool_bias_sigma_mm"] = bias->sigma / kMillimetre;
  }
  return keys;
}

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
  print(report);
  print(report.result.cell);
  print(comparison);
  nlohmann::json keys = figures(report);
  keys["comparison"] = figures(comparison);
  return {keys};
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
