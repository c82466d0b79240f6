#include <spdlog/spdlog.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/pairs/health_of_recording.h"
#include "planar_servo/offline/pairs/laid_boards.h"
#include "planar_servo/offline/pairs/pair_files.h"
#include "planar_servo/offline/pairs/pair_page.h"
#include "planar_servo/offline/pairs/pair_tracker.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-pair-tracker",
    "planar-pair-tracker --cell cell.yaml --lamps lamps.csv --recording RECORDING "
    "[--workplane-from pairs|grid] --workplane-out workplane.yaml --tool-out tool.yaml "
    "[--grid BOARD] [--board-thickness-mm T] [--lays-out lays.csv] "
    "[--accept-step] [--health-out health.yaml] [--report FILE.html|none] -o pairs.csv",
    R"(datum               3 monuments, rms 0.0045 mm
workplane           6 degrees of freedom fitted to 51 places, rms 0.0845 mm
tool                end point (0.0576, 0.0482) mm, reflector (11.8112, -8.1389) mm
rejected            train_17: vision and tracker differ by 4.641 mm; the limit is 0.817 mm
raw error           train: 39 pairs, mean 0.079 mm, rms 0.093 mm, max 0.227 mm)"};

struct Options {
  std::filesystem::path cell, lamps, recording, tracker, health_out, lays_out;
  PairFiles out;
  WorkplaneSource source{WorkplaneSource::kPairs};
  double unit{kMillimetre};  ///< of the tracker's table, metres
  std::string grid, pair_by{"id"}, columns, report;
  char separator{','};
  bool decimal_comma{false}, accept_step{false};
  double board_thickness_mm{0.0};
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_required(app, "--lamps", options.lamps, "lamps.csv", "made by planar-locate-lamps");
  add_required(app, "--recording", options.recording, "DIR", "folder made by planar-record");
  add_choice(app, "--workplane-from", options.source, kWorkplaneSources,
             "the source of the plane's height and tilt");
  auto* grid =
      add_value(app, "--grid", options.grid, "BOARD",
                "board laid on the plane, circles:COLSxROWS:PITCHmm; ? for an unknown pitch "
                "when the pairs give the plane");
  add_value(app, "--board-thickness-mm", options.board_thickness_mm, "T",
            "by how much the board's dots lie above the plane in which the lamps move; "
            "negative for dots below the lamps")
      ->check(within(-1000.0, 1000.0))
      ->needs(grid);
  add_value(app, "--lays-out", options.lays_out, "lays.csv",
            "lays.csv to write: every dot of the boards laid on the plane, where it is seen")
      ->needs(grid);
  add_choice(app, "--pair-by", options.pair_by, {"id", "time"},
             "how frames and readings are matched");
  add_value(app, "--tracker", options.tracker, "FILE",
            "the tracker's table of readings; by default RECORDING/tracker.csv");
  app.add_option("--tracker-columns", options.columns,
                 "names of the columns in the tracker's table, or their numbers from 1 on: "
                 "x=X,y=Y,z=Z,id=NAME or id=1,x=2,y=3,z=4");
  add_choice(app, "--tracker-unit", options.unit, kTrackerUnits,
             "the unit of x, y and z in the tracker's table");
  app.add_option("--separator", options.separator,
                 "what separates the columns in the tracker's table; ' ' for blanks and tabs")
      ->capture_default_str();
  app.add_flag("--decimal-comma", options.decimal_comma,
               "numbers in the tracker's table are written as 1,5");
  app.add_flag("--accept-step", options.accept_step,
               "write the pairs although something seems to have moved between them, which would "
               "cost more than 0.05 mm at the end point");
  add_required(app, "--workplane-out", options.out.workplane, "workplane.yaml",
               "the workplane to write");
  add_required(app, "--tool-out", options.out.tool, "tool.yaml", "the tool's offsets to write");
  add_value(app, "--health-out", options.health_out, "health.yaml",
            "health.yaml to write: places and measures by which planar-check-cell and "
            "planar-servo see later what has changed");
  add_report_option(app, options.report);
  add_required(app, "-o,--out", options.out.pairs, "pairs.csv", "the pairs to write");
}

RecordedTables tables_of(const Options& options) {
  return {options.lamps, options.recording / "frames.csv",
          options.tracker.empty() ? options.recording / "tracker.csv" : options.tracker};
}

void check_outputs(const Options& options, const CellSettings& cell) {
  const RecordedTables tables = tables_of(options);
  require_outputs({{options.out.workplane, "workplane"},
                   {options.out.tool, "tool"},
                   {options.out.pairs, "pairs"},
                   {options.health_out, "health"},
                   {options.lays_out, "lays"}},
                  {options.cell, cell.camera_model, tables.lamps, tables.frames, tables.tracker});
}

/// Returns the board that was laid on the plane, where one is needed.
std::optional<Board> board_of(const Options& options) {
  const bool gives_plane = options.source == WorkplaneSource::kBoard;
  if (!gives_plane && options.lays_out.empty()) return std::nullopt;
  if (options.grid.empty())
    throw InputError("--workplane-from grid needs --grid circles:COLSxROWS:PITCHmm");
  const Board board =
      parse_board(options.grid, gives_plane ? BoardUse::kLengths : BoardUse::kShape);
  if (!options.lays_out.empty() && !board.has_dots())
    throw InputError({"--lays-out needs a board of dots, not '" + options.grid + "'",
                      "lay one such as circles:11x11:50mm"});
  return board;
}

PairTrackerRequest read_request(const Options& options) {
  if (options.decimal_comma && options.separator == ',')
    throw InputError("--decimal-comma needs another --separator than ',', such as ';'");
  const std::optional<Board> board = board_of(options);
  PairTrackerRequest request;
  request.by = options.pair_by == "time" ? PairBy::kTime : PairBy::kId;
  request.cell = read_cell(options.cell);
  check_outputs(options, request.cell);
  request.camera = read_cell_camera(request.cell);
  request.lamps = read_lamps(options.lamps);
  request.frames = read_frames(options.recording);
  require_belonging(stale_tables(request.cell, tables_of(options)));
  if (!options.tracker.empty() || !holds_no_row(tables_of(options).tracker, tracker_header()))
    request.tracker = read_tracker(
        tables_of(options).tracker,
        {{options.separator, options.decimal_comma, renamed_tracker_columns(options.columns)},
         options.unit},
        request.by == PairBy::kTime);
  request.accept_step = options.accept_step;
  request.dots_height = options.board_thickness_mm * kMillimetre;
  if (options.source == WorkplaneSource::kBoard)
    request.boards_on_plane =
        boards_on_plane(options.recording, request.frames, request.camera, *board);
  return request;
}

/// Names the errors of the arm that the recording shows, and keeps the present state of the cell.
void look_at_cell(const Options& options, const PairTrackerRequest& request,
                  const PairTrackerReport& report) {
  const VisionCalibration vision{request.cell.lamps.layout,
                                 Workplane(request.camera, report.workplane.X_WC),
                                 report.workplane.tool};
  const std::vector<SeenPlace> seen =
      seen_places(request.cell, vision, request.frames, request.lamps);
  for (const HealthFinding& finding : arm_faults(request.cell, vision, seen))
    spdlog::warn(finding.text());
  if (!options.health_out.empty())
    write_health_file(options.health_out, request.cell, options.out, health_of(request.cell, seen),
                      kText.name);
}

/// Writes where the boards' dots are seen on the plane, and returns what is said of it.
std::string write_lays(const Options& options, const PairTrackerRequest& request,
                       const std::vector<LaidBoard>& boards, const WorkplaneFit& fit) {
  const std::vector<LayRow> lays =
      seen_lays(Workplane(request.camera, fit.X_WC), boards, request.dots_height);
  for (const Refusal& doubt :
       doubts_of_lays(lays, fit.X_WC.translation().z() - request.dots_height))
    spdlog::warn(doubt.text());
  write_lays_file(options.lays_out, request.cell, options.out, tables_of(options), lays);
  return fmt::format("{:<20}{} views of the board on the plane, {} dots\n", "lays", boards.size(),
                     lays.size());
}

Outcome pair(const Options& options) {
  const auto page = page_for(options.report, options.out.pairs);
  const PairTrackerRequest request = read_request(options);
  std::vector<LaidBoard> boards = request.boards_on_plane;
  if (boards.empty() && !options.lays_out.empty())
    boards = boards_on_plane(options.recording, request.frames, request.camera,
                             board_of(options).value());
  const PairTrackerReport report = pair_tracker(request);
  write_pair_files(options.out, request.cell, tables_of(options), report.workplane, options.source,
                   report.pairs, kText.name);
  look_at_cell(options, request, report);
  Outcome outcome = told(pair_tracker_list(report));
  if (page) write_page(*page, pair_page(request, report, options.out.pairs));
  if (!options.lays_out.empty()) say("{}", write_lays(options, request, boards, report.workplane));
  return outcome;
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::pair);
}
