#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "app/progress.h"
#include "app/servo_report.h"
#include "app/servo_run.h"
#include "core/error.h"
#include "core/units.h"
#include "program.h"
#include "text/atomic_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-servo", "Positions the end point at targets by vision and logs every step.",
    "planar-servo --cell cell.yaml --targets targets.csv --out DIR [--no-error-map] [--resume]\n"
    "       planar-servo --cell cell.yaml --targets targets.csv --dry-run | --check",
    "  100 of 100 targets reached, 2 corrections and 2.13 s each\n"
    "  against the truth: before 1.318 mm mean; after 0.0210 mm mean, 0.0240 rms, ..."};

struct Options {
  fs::path cell, targets, out;
  bool no_error_map{false}, dry_run{false}, check{false}, resume{false};
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
  app.add_option("--targets", options.targets, "where the end point is wanted")
      ->required()
      ->type_name("FILE");
  auto* out = app.add_option("--out", options.out, "folder for log and report")->type_name("DIR");
  app.add_flag("--no-error-map", options.no_error_map, "use vision as it is");
  app.add_flag("--resume", options.resume, "go on with the run in DIR");
  auto* dry = app.add_flag("--dry-run", options.dry_run,
                           "print the first move to each target; nothing moves")
                  ->excludes(out);
  app.add_flag("--check", options.check, "read and check every file; nothing moves")
      ->excludes(out)
      ->excludes(dry);
}

Outcome print_dry_run(const CellSettings& cell, const std::vector<TargetRow>& targets) {
  bool all_possible = true;
  nlohmann::json rows = nlohmann::json::array();
  for (const DryRunRow& row : dry_run(cell, targets)) {
    if (row.plan.refusal) {
      all_possible = false;
      fmt::print("{}: refused: {}\n", row.id, *row.plan.refusal);
      rows.push_back({{"target", row.id}, {"refused", *row.plan.refusal}});
      continue;
    }
    const Eigen::Vector3d deg = row.plan.theta / kDegree;
    fmt::print("{}: joints {:.4f} {:.4f} {:.4f} deg, pulses {} {} {}\n", row.id, deg[0], deg[1],
               deg[2], row.pulses[0], row.pulses[1], row.pulses[2]);
    rows.push_back({{"target", row.id},
                    {"theta_deg", {deg[0], deg[1], deg[2]}},
                    {"pulses", {row.pulses[0], row.pulses[1], row.pulses[2]}}});
  }
  return {{{"moves", rows}}, all_possible};
}

Outcome print_check(const fs::path& file, const CellSettings& cell,
                    const std::vector<TargetRow>& targets) {
  std::size_t refused = 0;
  for (const DryRunRow& row : dry_run(cell, targets)) {
    if (!row.plan.refusal) continue;
    ++refused;
    fmt::print("{}: refused: {}\n", row.id, *row.plan.refusal);
  }
  fmt::print("{} and the files it names are in order; {} of {} targets can be reached\n",
             file.string(), targets.size() - refused, targets.size());
  return {{{"targets", targets.size()}, {"refused", refused}}, refused == 0};
}

Outcome run(const ServoRequest& request, const Options& options) {
  const auto devices = open_cell(request.cell);
  const auto results = run_servo(request, *devices);
  for (const TargetResult& result : results)
    if (result.status != ServoStatus::kReached)
      spdlog::warn("{}: {}: {}", result.id, name(result.status), result.reason);
  const ServoFigures figures = figures_of(results);
  std::vector<fs::path> inputs{options.cell, options.targets, request.cell.camera_model,
                               request.cell.workplane, request.cell.tool};
  if (request.use_error_map) inputs.push_back(request.cell.error_map);
  write_file(request.out / "run.yaml", run_text(request, figures, inputs));
  write_file(request.out / "report.html", servo_page(request, results));
  fmt::print("{}log and report: {}\n", servo_text(figures), request.out.string());
  return {servo_json(figures), figures.reached == figures.targets};
}

Outcome work(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  const auto targets = read_targets(options.targets);
  if (options.dry_run) return print_dry_run(cell, targets);
  if (options.check) {
    require_devices(cell);
    read_vision(cell, !options.no_error_map);
    return print_check(options.cell, cell, targets);
  }
  if (options.out.empty())
    throw InputError("--out is needed to move; --dry-run and --check do without");
  const ProgressBar bar("targets");
  ServoRequest request{cell,
                       targets,
                       CenterMethod::kAuto,
                       !options.no_error_map,
                       options.out,
                       options.resume,
                       [&](std::size_t done, std::size_t all) { bar.show(done, all); }};
  return run(request, options);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
