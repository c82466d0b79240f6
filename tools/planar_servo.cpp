#include <spdlog/spdlog.h>

#include <iostream>
#include <set>

#include "homing_options.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/drawings/drawing.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/machine/plausibility.h"
#include "planar_servo/report/live_view.h"
#include "planar_servo/work/run/cell_check.h"
#include "planar_servo/work/run/dry_run.h"
#include "planar_servo/work/run/path_report.h"
#include "planar_servo/work/run/servo_report.h"
#include "planar_servo/work/run/servo_run.h"
#include "planar_servo/work/run/target_stream.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const ProgramText kText{
    "planar-servo",
    "planar-servo --cell cell.yaml --targets targets.csv --out DIR [--work work.yaml]\n"
    "                    [--tool NAME] [--layers NAME,...] [--drawing-unit UNIT] [--no-error-map]\n"
    "                    [--resume] [--centre METHOD] [--display auto|none] [--home] [--at-marks]\n"
    "                    [--nearest-turn] [--accept-stale] [--accept-map] [--no-health]\n"
    "                    [--keep-going] [--judged] [--forget]\n"
    "       planar-servo --cell cell.yaml --targets targets.csv --dry-run | --check\n"
    "                    [--report FILE.html]\n"
    "       ... | planar-servo --cell cell.yaml --targets - --out DIR [--require-end]\n"
    "       planar-servo --cell cell.yaml --path path.csv --out DIR [--speed-mm-s V,...]\n"
    "                    [--no-vision|--compare] [--work work.yaml]",
    R"(2 of 2 targets reached, 1 correction and 2.87 s each
against the truth: the arm alone 0.9240 mm mean; with vision 0.0130 mm mean, 0.0130 rms, 0.0134 at 95 %, 0.0135 max
log and report: DIR)"};

constexpr char kStdin[] = "standard input";

constexpr Named<double> kDrawingUnits[] = {
    {kMillimetre, "mm"}, {10.0 * kMillimetre, "cm"}, {1.0, "m"}, {kInch, "inch"}};

struct Options {
  fs::path cell, targets, path, work;
  ServoRequest request;
  DrawingSettings drawing;
  std::string drawing_unit, tool;
  fs::path report;                  ///< of a check or dry run; empty for none
  std::vector<double> speeds_mm_s;  ///< empty: the drawing's, or else the usual one
  DisplayPolicy display{DisplayPolicy::kNone};
  std::string center;  ///< empty: the cell's lamps.method
  bool no_error_map{false}, no_health{false}, dry_run{false}, check{false}, judged{false};
  HomingOptions homing;
  bool no_vision{false}, compare{false}, require_end{false};
};

/// Adds where the end point is to go: targets or a path.
void add_goals(CLI::App& app, Options& options) {
  auto* goals = app.add_option_group("where to");
  add_value(
      *goals, "--targets", options.targets, "targets.csv",
      "table of targets, or a drawing whose points they are: DXF (.dxf), G-code (.nc, .gcode, "
      "...); '-' reads lines id,x_mm,y_mm[,phi_deg] from standard input "
      "and answers each with one line of JSON");
  auto* path = add_value(*goals, "--path", options.path, "path.csv",
                         "table of the places that a path goes through, straight or on arcs, or "
                         "a drawing, as DXF or G-code");
  goals->require_option(1);
  app.add_flag(
      "--require-end", options.require_end,
      "with --targets -: call the run failed unless the line 'end' ends the targets, as it "
      "does not when their writer was killed");
  add_value(
      app, "--work", options.work, "work.yaml",
      "the workpiece that planar-find-work found: targets and paths are in the coordinates of "
      "its drawing; it is looked at again every minute and at the end");
  add_value(app, "--tool", options.tool, "NAME",
            "the cell's tool whose tip goes to targets that name none in a column tool; by default "
            "the end point on joint 3's axis does")
      ->excludes(path);
  add_value(app, "--speed-mm-s", options.speeds_mm_s, "V,...",
            "speeds along the path, 1 to 50; it is followed once at each; by default the "
            "drawing's feed, or 10")
      ->delimiter(',')
      ->needs(path);
  add_value(app, "--layers", options.drawing.layers, "NAME,...",
            "layers of a DXF to read; by default all")
      ->delimiter(',');
  app.add_option("--drawing-unit", options.drawing_unit,
                 "unit of a DXF, instead of its header's, which may name none")
      ->check(CLI::IsMember(names_of(kDrawingUnits)));
  auto* no_vision =
      app.add_flag("--no-vision", options.no_vision,
                   "follow the path by the arm's model alone; vision watches and corrects nothing")
          ->needs(path);
  app.add_flag("--compare", options.compare,
               "follow the path at each speed without vision first, then with it")
      ->needs(path)
      ->excludes(no_vision);
}

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_goals(app, options);
  auto* out =
      add_value(app, "--out", options.request.folder.path, "DIR", "folder for log and report");
  app.add_flag("--no-error-map", options.no_error_map, "use vision without the error map");
  app.add_option("--centre", options.center,
                 "how a lamp's centre is measured; by default the cell's lamps.method")
      ->check(CLI::IsMember(names_of(kCenterMethods)));
  add_homing_options(app, options.homing);
  app.add_flag("--accept-stale", options.request.accepted.stale,
               "move even with files that were not made from one another; the run says which");
  app.add_flag("--accept-map", options.request.accepted.map, kAcceptMap);
  app.add_flag("--no-health", options.no_health,
               "move without checking first that the cell is as it was calibrated");
  app.add_flag("--keep-going", options.request.accepted.doubts,
               "try the next target even when the cell itself is in doubt: after a look that "
               "contradicts the command or the calibration, or an error that grew");
  app.add_flag("--forget", options.request.policy.forgets,
               "learn the arm from the start, without the cell's arm_learned file")
      ->excludes("--path");
  app.add_flag(
         "--judged", options.judged,
         "let the tracker of a real cell judge every target: it asks for the reflector on the "
         "monuments, then on the tool, and its readings stand in judge.csv")
      ->needs(out)
      ->excludes("--path");
  app.add_flag("--resume", options.request.folder.resume, "continue the run in DIR")
      ->needs(out)
      ->excludes("--path");
  add_choice(app, "--display", options.display, kDisplayPolicies,
             "auto: draw every step into DIR/view.png; none")
      ->excludes("--path");
  auto* dry = app.add_flag("--dry-run", options.dry_run,
                           "print the first move to each target; nothing moves")
                  ->excludes(out);
  app.add_flag("--check", options.check, "read and check every file; nothing moves")
      ->excludes(out)
      ->excludes(dry);
  add_value(app, "--report", options.report, "FILE.html",
            "with --check or --dry-run: draw what would be done on a page")
      ->excludes(out);
}

/// Reads a drawing, and says what it leaves open.
Drawing drawing_in(const fs::path& file, const Options& options) {
  DrawingSettings settings = options.drawing;
  if (!options.drawing_unit.empty())
    settings.unit_m = value_named(kDrawingUnits, options.drawing_unit);
  Drawing drawing = read_drawing(file, settings);
  if (!options.path.empty()) drawing.remarks = path_remarks(drawing);
  for (const std::string& remark : drawing.remarks)
    spdlog::warn(Refusal{remark}.at(file.string()).text());
  return drawing;
}

std::string title_of(const ServoSight& sight) {
  const ServoStep& step = sight.step;
  const std::string what = fmt::format("{}   step {}", sight.target_id, step.iteration);
  if (!step.measurement.ok())
    return fmt::format("{}   not measured: {}", what, step.measurement.word);
  return fmt::format("{}   {:.4f} mm from the target, +- {:.4f} mm{}", what, mm(step.miss_m()),
                     mm(step.uncertainty_m()),
                     step.measurement.inside_map ? "" : "   outside the error map");
}

/// Shows every step of a servo as it is measured: the lamps (crosses), where they belong (rings),
/// and the errors of this target so far.
class ServoDisplay {
 public:
  /// Draws into the file `picture` where the policy asks for that.
  ServoDisplay(DisplayPolicy policy, const fs::path& picture)
      : picture_(open_display(policy, picture)) {}

  void show(const ServoSight& sight) {
    using Color = LiveView::Color;
    if (!picture_) return;
    const ServoStep& step = sight.step;
    if (step.iteration == 0) lines_ = {{"error after each step", Color::kInk}};
    LiveView view{title_of(sight), sight.frame.image};
    view.corner_px = cv::Rect2d(sight.frame.region_px).tl();
    if (sight.wanted_px)
      for (const Eigen::Vector2d& uv : *sight.wanted_px)
        view.marks.push_back({uv, LiveView::Shape::kRing, 26.0, Color::kWanted});
    if (step.measurement.ok()) {
      for (const Eigen::Vector2d& uv : step.measurement.lamps_px)
        view.marks.push_back({uv, LiveView::Shape::kCross, 6.0, Color::kSeen});
      const bool is_content = step.miss_m() <= step.stop_below_m;
      lines_.push_back({fmt::format("{}: {:.4f} mm", step.iteration, mm(step.miss_m())),
                        is_content ? Color::kSeen : Color::kWanted});
    }
    view.lines = lines_;
    picture_->show(view);
  }

 private:
  std::unique_ptr<LivePicture> picture_;  ///< null when nothing is drawn
  std::vector<LiveView::Line> lines_;
};

bool from_stdin(const Options& options) {
  return options.targets == "-";
}

/// Returns where the check of the cell leaves the arm, and warns of what it cannot do. Throws
/// InputError where it can do nothing.
Joints start_of_run(const Options& options, const CalibratedCell& cell) {
  if (options.no_health) return cell.settings.arm.home;
  const ForeseenCheck check = foresee_check(cell);
  if (check.refused) throw InputError(*check.doubt);
  if (check.doubt) spdlog::warn(check.doubt->text());
  return check.end;
}

/// The targets of a table or drawing, and what the drawing leaves open.
struct TargetsIn {
  std::vector<TargetRow> rows;
  std::vector<std::string> remarks{};
};

TargetsIn drawn_targets(const Options& options) {
  if (from_stdin(options)) return {};
  if (!is_drawing(options.targets)) return {read_targets(options.targets)};
  const Drawing drawing = drawing_in(options.targets, options);
  return {targets_of(drawing, options.targets.string()), drawing.remarks};
}

TargetsIn targets_in(const Options& options, CellTools& tools) {
  TargetsIn targets = drawn_targets(options);
  if (const auto& laid = options.request.works) {
    if (const auto doubt = doubt_on_work(targets.rows, laid->works.front()))
      spdlog::warn(doubt->at(options.targets.string()).text());
    targets.rows = on_works(targets.rows, laid->works);
  }
  targets.rows = tools.with_tips(targets.rows);
  return targets;
}

/// Returns the only work of the run's file. Throws InputError for several.
const FoundWork& single_work(const Options& options) {
  const LaidWorks& laid = *options.request.works;
  if (laid.works.size() > 1)
    throw InputError({fmt::format("names {} works, and a path or a target from standard input lies "
                                  "on one",
                                  laid.works.size()),
                      "find each by itself with planar-find-work --near", laid.file});
  return laid.works.front();
}

/// Plans the first move to each target, and draws it where a page is wanted. A check refuses
/// targets outside the error map, too.
std::vector<DryRunRow> planned_moves(const Options& options, const CalibratedCell& cell,
                                     const TargetsIn& targets) {
  auto rows = first_moves_to(cell, start_of_run(options, cell), targets.rows);
  if (options.check) refuse_outside_map(rows, targets.rows, cell);
  if (!options.report.empty())
    write_file(options.report, plan_page(cell.settings.workspace, options.targets, targets.rows,
                                         rows, targets.remarks));
  return rows;
}

Outcome print_check(const CalibratedCell& cell, const std::vector<DryRunRow>& rows) {
  const std::vector<DryRunRow> refused = refused_of(rows);
  say("{}{} and the files it names are in order; {} of {} targets can be reached\n",
      dry_run_text(refused), cell.settings.file.string(), rows.size() - refused.size(),
      rows.size());
  return {{{"targets", rows.size()}, {"refused", refused.size()}}, refused.empty()};
}

/// Returns whether all lines of a stream were good and it ended as it had to.
bool is_good(const StreamEnd& end, bool requires_end) {
  const bool is_missing = requires_end && !end.was_said;
  if (is_missing)
    spdlog::error(
        "standard input ended without the line 'end', as when its writer was killed; targets may "
        "be missing");
  return end.bad_lines == 0 && !is_missing;
}

TargetRow in_base(const TargetRow& drawn, const Options& options, CellTools& tools) {
  std::vector<TargetRow> rows{drawn};
  if (options.request.works) rows = on_works(rows, {single_work(options)});
  return tools.with_tips(rows).front();
}

Outcome plan_stream(const Options& options, const CalibratedCell& cell, CellTools& tools) {
  TargetLines lines(kStdin);
  const FirstMoveStream planned =
      answer_first_moves(std::cin, std::cout, lines, cell, start_of_run(options, cell),
                         [&](const TargetRow& drawn) { return in_base(drawn, options, tools); });
  say(stderr, "{} of {} targets can be reached; {} bad lines\n", planned.targets - planned.refused,
      planned.targets, planned.end.bad_lines);
  return {{{"targets", planned.targets},
           {"refused", planned.refused},
           {"bad_lines", planned.end.bad_lines}},
          is_good(planned.end, options.require_end) && planned.refused == 0};
}

/// Moves to the targets of a table, or to those that arrive on standard input. Returns whether the
/// input was good.
bool move(ServoRun& run, const Options& options, CellTools& tools,
          const std::vector<TargetRow>& targets) {
  if (!from_stdin(options)) {
    ProgressBar bar("targets");
    run_servo(run, targets, [&](std::size_t done, std::size_t all) { bar.show(done, all); });
    return true;
  }
  std::set<std::string> taken;
  for (const TargetResult& result : run.results()) taken.insert(result.id);
  TargetLines lines(kStdin, std::move(taken));
  const StreamEnd end = answer_targets(std::cin, std::cout, lines, [&](const TargetRow& target) {
    return result_answer(run.move_to(in_base(target, options, tools)));
  });
  run.finish();
  return is_good(end, options.require_end);
}

Outcome report(const ServoRequest& request, const Options& options, const ServoRun& run,
               const FrameCounts& frames, bool good_input) {
  const ServoFigures figures =
      conclude_run(request, run, frames, from_stdin(options) ? fs::path() : options.targets);
  const ReportList list = servo_list(figures);
  say(from_stdin(options) ? stderr : stdout, "{}log and report: {}\n", list.text(),
      request.folder.path.string());
  return {list.json(), figures.reached == figures.targets && good_input && !run.ended_by()};
}

ServoRequest request_of(const Options& options, const std::shared_ptr<CalibratedCell>& cell) {
  if (options.judged && from_stdin(options))
    throw InputError(
        Refusal{"--judged asks a person at the terminal, but --targets - reads targets there",
                "name a table of targets"});
  if (options.request.folder.path.empty())
    throw InputError(
        Refusal{"--out is needed to move the arm", "only --dry-run and --check do without it"});
  ServoRequest request = options.request;
  request.cell = cell;
  request.policy.center = options.center.empty() ? cell->settings.lamps.method
                                                 : *value_named(kCenterMethods, options.center);
  if (request.policy.center != cell->settings.lamps.method)
    spdlog::warn(
        "--centre: {} may see lamps elsewhere than lamps.method {}, by which they were calibrated "
        "unless planar-locate-lamps had --centre, too: positions, and the check of the cell, may "
        "be off by that; calibrate and position by one method",
        options.center, name_in(kCenterMethods, cell->settings.lamps.method));
  request.policy.checks_health = !options.no_health;
  request.may_home = may_home(options.homing, !from_stdin(options));
  request.stop = interrupted;
  return request;
}

/// Checks all that a run would use.
void check_files(const Options& options, const CalibratedCell& cell) {
  require_devices(cell.settings);
  warn_of_values(cell.settings);
  require_calibrated(cell);
  accept_stale(cell.stale, options.request.accepted.stale);
  accept_map(cell, options.request.accepted.map);
}

/// Returns the tracker as the judge of a run, or null for a cell that its truth judges. It reads
/// the monuments when it is asked first.
std::shared_ptr<Judge> judge_by_tracker(const ServoRequest& request, CellDevices& devices) {
  require_calibrated(*request.cell);
  const CellSettings& cell = request.cell->settings;
  const ToolOffsets& tool = request.cell->vision->tool;
  if (judge_of(cell, tool) == JudgeKind::kTruth) return nullptr;
  return std::make_shared<TrackerJudge>(cell, tool, devices.tracker(),
                                        request.folder.path / "judge.csv", request.stop);
}

Outcome reach_targets(const Options& options, const std::shared_ptr<CalibratedCell>& cell) {
  CellTools tools(cell->settings, options.tool, options.request.accepted.stale);
  const TargetsIn read = targets_in(options, tools);
  const std::vector<TargetRow>& targets = read.rows;
  if (!from_stdin(options)) question_targets(targets, cell->settings.workspace, options.targets);
  if (options.check) check_files(options, *cell);
  if (options.check || options.dry_run) {
    if (from_stdin(options)) return plan_stream(options, *cell, tools);
    const std::vector<DryRunRow> rows = planned_moves(options, *cell, read);
    if (options.check) return print_check(*cell, rows);
    say("{}", dry_run_text(rows));
    return {dry_run_json(rows), refused_of(rows).empty()};
  }
  ServoRequest request = request_of(options, cell);
  request.policy.learns = cell->settings.servo.learns;
  heed_interrupts();
  const auto devices = open_cell(cell->settings);
  if (options.judged) request.judge = judge_by_tracker(request, *devices);
  ServoDisplay display(options.display, options.request.folder.path / "view.png");
  ServoRun run(request, *devices, [&](const ServoSight& sight) { display.show(sight); });
  const bool good_input = move(run, options, tools, targets);
  return report(request, options, run, devices->camera().counts(), good_input);
}

std::vector<Guidance> guidances_of(const Options& options) {
  if (options.compare) return {Guidance::kArm, Guidance::kVision};
  return {options.no_vision ? Guidance::kArm : Guidance::kVision};
}

/// Returns the speeds that a person wants, or else that of the drawing or the usual one.
std::vector<double> speeds_of(const Options& options, const std::optional<Drawing>& drawing) {
  if (!options.speeds_mm_s.empty() || !drawing || !drawing->speed_m_s)
    return path_speeds(options.speeds_mm_s.empty() ? std::vector{kUsualSpeed_mm_s}
                                                   : options.speeds_mm_s);
  try {
    return path_speeds({mm(*drawing->speed_m_s)});
  } catch (const InputError& e) {
    throw InputError(
        {fmt::format("its feed is {:g} mm/s; {}", mm(*drawing->speed_m_s), e.refusal().fault),
         "name a speed with --speed-mm-s", options.path, e.refusal().cause});
  }
}

/// Returns the path of a table or drawing in the base frame.
Path path_in_base(const Options& options, const std::optional<Drawing>& drawing, double phi) {
  const double turn = options.request.works ? single_work(options).pose.turn() : 0.0;
  const Path drawn =
      drawing ? path_of(*drawing, phi - turn, options.path) : read_path(options.path, phi - turn);
  return options.request.works ? on_work(drawn, single_work(options).pose) : drawn;
}

Outcome follow(const Options& options, const std::shared_ptr<CalibratedCell>& cell) {
  const double phi = cell->settings.tool_orientation;
  std::optional<Drawing> drawing;
  if (is_drawing(options.path)) drawing = drawing_in(options.path, options);
  const PathRequest path{options.path, path_in_base(options, drawing, phi), guidances_of(options),
                         speeds_of(options, drawing)};
  if (!options.report.empty())
    write_file(options.report, plan_page(cell->settings.workspace, options.path, path.path,
                                         drawing ? drawing->remarks : std::vector<std::string>()));
  const std::vector<PathDemand> demands = require_followable(*cell, path);
  if (options.check) {
    check_files(options, *cell);
    require_inside_map(*cell->vision, path);
  }
  if (options.check || options.dry_run) return told(path_demand_list(path, demands));
  const ServoRequest request = request_of(options, cell);
  heed_interrupts();
  const auto devices = open_cell(cell->settings);
  PathRun run(request, path, *devices);
  const bool reached = follow_path(run, path);
  write_path_run(request, path, run);
  const ReportList list = path_list(path, run.results());
  say("{}log and report: {}\n", list.text(), request.folder.path.string());
  return {list.json(), reached};
}

Outcome work(const Options& given) {
  Options options = given;
  if (!options.report.empty() && (from_stdin(options) || !(options.check || options.dry_run)))
    throw InputError(Refusal{"--report draws what --check or --dry-run find for a table or drawing",
                             "add one of them; a run writes its report into DIR"});
  if (!options.report.empty()) require_writable(options.report, "page");
  const fs::path& goals = options.path.empty() ? options.targets : options.path;
  if (!is_drawing(goals) && (!options.drawing.layers.empty() || !options.drawing_unit.empty()))
    throw InputError({"is no DXF, whose layers and unit could be chosen",
                      "leave --layers and --drawing-unit out; tables are in millimetres",
                      from_stdin(options) ? kStdin : goals.string()});
  if (options.require_end && !from_stdin(options))
    throw InputError(Refusal{"--require-end is for targets on standard input", "add --targets -"});
  const auto cell = std::make_shared<CalibratedCell>(
      read_calibrated_cell(read_cell(options.cell), !options.no_error_map));
  if (!options.work.empty())
    options.request.works = read_works(options.work, *cell, options.request.accepted.stale);
  return options.path.empty() ? reach_targets(options, cell) : follow(options, cell);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
