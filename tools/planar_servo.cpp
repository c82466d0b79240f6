#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <iostream>
#include <set>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/report/progress_bar.h"
#include "planar_servo/run/servo_display.h"
#include "planar_servo/run/servo_report.h"
#include "planar_servo/run/servo_run.h"
#include "planar_servo/run/target_stream.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-servo", "Positions the end point at targets by vision and logs every step.",
    "planar-servo --cell cell.yaml --targets targets.csv --out DIR [--no-error-map] [--resume]\n"
    "                    [--display auto|x|none] [--home]\n"
    "       planar-servo --cell cell.yaml --targets targets.csv --dry-run | --check\n"
    "       ... | planar-servo --cell cell.yaml --targets - --out DIR",
    R"(2 of 2 targets reached, 1.5 corrections and 2.87 s each
against the truth: before 0.924 mm mean; after 0.0130 mm mean, 0.0130 rms, 0.0134 at 95 %, 0.0135 max; improvement 98.6 %
log and report: DIR)"};

constexpr char kStdin[] = "standard input";

struct Options {
  fs::path cell, targets, out;
  std::string display{"none"};
  bool no_error_map{false}, dry_run{false}, check{false}, resume{false}, home{false};
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--cell", options.cell, "the cell")->required()->type_name("FILE");
  app.add_option(
         "--targets", options.targets,
         "where the end point is wanted; with '-', lines id,x_mm,y_mm[,phi_deg] on standard "
         "input, each answered by one line of JSON")
      ->required()
      ->type_name("FILE");
  auto* out = app.add_option("--out", options.out, "folder for log and report")->type_name("DIR");
  app.add_flag("--no-error-map", options.no_error_map, "use vision as it is");
  app.add_flag("--home", options.home,
               "home drives that lost their position, which moves the arm; without it a terminal "
               "is asked");
  app.add_flag("--resume", options.resume, "go on with the run in DIR")->needs(out);
  app.add_option(
         "--display", options.display,
         "auto: draw every step into DIR/view.png and, where an X server answers, a window; "
         "x: insist on the window; none")
      ->check(CLI::IsMember({"auto", "x", "none"}))
      ->capture_default_str();
  auto* dry = app.add_flag("--dry-run", options.dry_run,
                           "print the first move to each target; nothing moves")
                  ->excludes(out);
  app.add_flag("--check", options.check, "read and check every file; nothing moves")
      ->excludes(out)
      ->excludes(dry);
}

bool from_stdin(const Options& options) {
  return options.targets == "-";
}

bool may_home(const Options& options, const std::string& unhomed) {
  if (options.home) return true;
  if (from_stdin(options) || isatty(STDIN_FILENO) == 0) return false;
  fmt::print(stderr, "{}. Search their home switches now? The arm will move. [y/N] ", unhomed);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y";
}

Outcome print_dry_run(const CellSettings& cell, const std::vector<TargetRow>& targets) {
  DryRun dry(cell);
  bool all_possible = true;
  nlohmann::json moves = nlohmann::json::array();
  for (const TargetRow& target : targets) {
    const DryRunRow row = dry.plan(target);
    moves.push_back(nlohmann::json(plan_answer(row)));
    if (row.plan.refusal) {
      all_possible = false;
      fmt::print("{}: refused: {}\n", row.id, *row.plan.refusal);
      continue;
    }
    fmt::print("{}: joints {} deg, pulses {} {} {}\n", row.id,
               fixed(row.plan.theta / kDegree, 4, " "), row.pulses[0], row.pulses[1],
               row.pulses[2]);
  }
  return {{{"moves", moves}}, all_possible};
}

Outcome print_check(const fs::path& file, const CellSettings& cell,
                    const std::vector<TargetRow>& targets) {
  DryRun dry(cell);
  std::size_t refused = 0;
  for (const TargetRow& target : targets) {
    const DryRunRow row = dry.plan(target);
    if (!row.plan.refusal) continue;
    ++refused;
    fmt::print("{}: refused: {}\n", row.id, *row.plan.refusal);
  }
  fmt::print("{} and the files it names are in order; {} of {} targets can be reached\n",
             file.string(), targets.size() - refused, targets.size());
  return {{{"targets", targets.size()}, {"refused", refused}}, refused == 0};
}

/// Plans the targets that arrive on standard input; nothing moves.
Outcome plan_stream(const CellSettings& cell) {
  DryRun dry(cell);
  TargetLines lines(kStdin);
  std::size_t targets = 0, refused = 0;
  const std::size_t bad_lines =
      answer_targets(std::cin, std::cout, lines, [&](const TargetRow& target) {
        const DryRunRow row = dry.plan(target);
        ++targets;
        if (row.plan.refusal) ++refused;
        return plan_answer(row);
      });
  fmt::print(stderr, "{} of {} targets can be reached; {} bad lines\n", targets - refused, targets,
             bad_lines);
  return {{{"targets", targets}, {"refused", refused}, {"bad_lines", bad_lines}},
          refused + bad_lines == 0};
}

/// Moves to the targets of a table, or to those that arrive on standard input. Returns the number
/// of bad lines.
std::size_t move(ServoRun& run, const Options& options, const std::vector<TargetRow>& targets) {
  if (!from_stdin(options)) {
    ProgressBar bar("targets");
    run_servo(run, targets, [&](std::size_t done, std::size_t all) { bar.show(done, all); });
    return 0;
  }
  std::set<std::string> taken;
  for (const TargetResult& result : run.results()) taken.insert(result.id);
  TargetLines lines(kStdin, std::move(taken));
  return answer_targets(std::cin, std::cout, lines, [&](const TargetRow& target) {
    return result_answer(run.move_to(target));
  });
}

Outcome report(const ServoRequest& request, const Options& options, const ServoRun& run,
               const FrameCounts& frames, std::size_t bad_lines) {
  for (const TargetResult& result : run.results())
    if (result.status != ServoStatus::kReached)
      spdlog::warn("{}: {}: {}", result.id, name(result.status), result.reason);
  ServoFigures figures = figures_of(run.results());
  figures.frames = frames;
  std::vector<fs::path> inputs{options.cell, request.cell.camera_model, request.cell.workplane,
                               request.cell.tool};
  if (!from_stdin(options)) inputs.push_back(options.targets);
  if (request.use_error_map) inputs.push_back(request.cell.error_map);
  write_file(request.out / "run.yaml", run_text(request, figures, inputs));
  write_file(request.out / "report.html", servo_page(request, run.results()));
  fmt::print(from_stdin(options) ? stderr : stdout, "{}log and report: {}\n", servo_text(figures),
             request.out.string());
  return {servo_json(figures), figures.reached == figures.targets && bad_lines == 0};
}

Outcome work(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  const std::vector<TargetRow> targets =
      from_stdin(options) ? std::vector<TargetRow>() : read_targets(options.targets);
  if (options.check) {
    require_devices(cell);
    read_vision(cell, !options.no_error_map);
  }
  if ((options.dry_run || options.check) && from_stdin(options)) return plan_stream(cell);
  if (options.dry_run) return print_dry_run(cell, targets);
  if (options.check) return print_check(options.cell, cell, targets);
  if (options.out.empty())
    throw InputError("--out is needed to move; --dry-run and --check do without");
  const ServoRequest request{cell,
                             CenterMethod::kAuto,
                             !options.no_error_map,
                             options.out,
                             options.resume,
                             [&](const std::string& unhomed) { return may_home(options, unhomed); },
                             interrupted};
  heed_interrupts();
  const auto devices = open_cell(request.cell);
  ServoDisplay display(display_policy_named(options.display), options.out / "view.png");
  ServoRun run(request, *devices, [&](const ServoSight& sight) { display.show(sight); });
  const std::size_t bad_lines = move(run, options, targets);
  display.close();
  return report(request, options, run, devices->camera().counts(), bad_lines);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
