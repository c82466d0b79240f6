#include <unistd.h>

#include <cmath>
#include <cstdint>

#include "paper_cell.h"
#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/line_reader.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/rehearsal/live_cell.h"
#include "planar_servo/machine/rehearsal/served_cell.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

const CommandText kDraw{
    "draw", "planar-virtual-cell draw --seed N [--like paper|rough|workshop|ordinary|cheap] -o DIR",
    "drew cell 7: cells/7/cell.yaml and its truth, cells/7/truth.yaml"};

const CommandText kServe{
    "serve",
    "planar-virtual-cell serve --cell cell.yaml [--out live.yaml] [--address ADDRESS]\n"
    "                                 [--tracker tcp|file] [--tracker-clock OFFSET_S,PPM]\n"
    "                                 [--decimal-comma] [--broken-beams PERCENT]\n"
    "                                 [--truth-log FILE] [--grbl-firmware PROGRAM|--shafts]",
    "serving cell.yaml until interrupted; live.yaml describes it as a real cell\n"
    "camera   GigE Vision on 127.0.0.1\n"
    "drives   Grbl at /home/me/grbl\n"
    "tracker  on 127.0.0.1:7701\n"
    "the board is held, view 0"};
const CommandText kPut{
    "put",
    "planar-virtual-cell put --cell cell.yaml --drawing work.csv --at X,Y,TURN [--higher-mm H]\n"
    "                               [--slide AT_S,DX,DY,TURN]",
    "put a work with 4 marks into cells/7/truth.yaml, its origin at (200.000, 240.000) mm"};
const ProgramText kText{
    "planar-virtual-cell",
    kDraw.synopsis + "\n       " + kServe.synopsis + "\n       " + kPut.synopsis,
    kDraw.sample,
    {kDraw, kServe, kPut}};

constexpr double kInputPeriod_s = 0.1;
constexpr char kTcp[] = "tcp", kFile[] = "file";

struct Options {
  std::uint32_t seed{0};
  std::string like{"paper"};
  fs::path folder;
  fs::path cell, live_cell, truth_log, firmware;
  std::string address{"127.0.0.1"}, tracker{kTcp};
  std::vector<double> tracker_clock{0.0, 0.0};
  bool decimal_comma{false}, shafts{false};
  double broken_percent{0.0};
  fs::path drawing;
  std::vector<double> at, slide;
  double higher_mm{0.0};
};

/// Names the reference lamps of a workshop's cell file, with the diameter of the tool's.
std::string reference_lamps_text() {
  std::string text = "reference_lamps:\n";
  for (const StatedLamp& lamp : workshop_lamps())
    text += fmt::format("  - {{id: {}, diameter_mm: 8.0, x_mm: {}, y_mm: {}}}\n", lamp.id,
                        std::round(mm(lamp.p_B.x())), std::round(mm(lamp.p_B.y())));
  return text;
}

/// Returns the paper's cell file with the tolerance and the lamps of cells of this kind.
std::string cell_text_like(DrawTruth kind) {
  const std::string paper = "tolerance_mm: 0.005";
  std::string text = kPaperCell;
  const auto stated = text.find(paper);
  if (kind == draw_ordinary_truth) text.replace(stated, paper.size(), "tolerance_mm: 0.010");
  if (kind == draw_cheap_truth) text.replace(stated, paper.size(), "tolerance_mm: 0.030");
  return kind == draw_workshop_truth ? text + reference_lamps_text() : text;
}

Outcome draw(const Options& options) {
  const DrawTruth draw_truth_like = value_named(kCellKinds, options.like).value();
  const fs::path cell = options.folder / "cell.yaml", truth = options.folder / "truth.yaml";
  for (const fs::path& path : {cell, truth})
    if (fs::exists(path))
      throw InputError({"exists already", "name another folder", path, Cause::kExists});
  make_folder(options.folder);
  write_file(cell, cell_text_like(draw_truth_like));
  Truth drawn = draw_truth_like(options.seed);
  drawn.build = build_as_stated(virtual_hardware(read_cell(cell)));
  write_truth(truth, drawn);
  say("drew cell {}: {} and its truth, {}\n", options.seed, cell.string(), truth.string());
  return {{{"seed", options.seed}, {"cell", cell.string()}, {"truth", truth.string()}}};
}

ServeRequest serve_request(const Options& options) {
  const fs::path folder = fs::absolute(options.cell).parent_path();
  ServeRequest request;
  request.cell = read_cell(options.cell);
  request.address = options.address;
  request.motor_port = folder / (options.shafts ? "shafts" : "grbl");
  request.firmware = options.firmware;
  request.board = options.shafts             ? ServedBoard::kShafts
                  : options.firmware.empty() ? ServedBoard::kEmulated
                                             : ServedBoard::kFirmware;
  if (options.tracker == kFile) request.tracker_file = folder / "tracker.txt";
  request.tracker = {options.tracker_clock[0], options.tracker_clock[1], options.decimal_comma,
                     options.broken_percent};
  if (!options.truth_log.empty()) request.truth_log = options.truth_log;
  return request;
}

void tell(const std::string& text) {
  say("{}\n", text);
  std::fflush(stdout);
}

Outcome serve(const Options& options) {
  const ServeRequest request = serve_request(options);
  const bool writes_cell = !options.live_cell.empty();
  if (writes_cell && fs::exists(options.live_cell))
    throw InputError({"exists already",
                      "name another file, or leave out --out, since served cells are found at the "
                      "same places again",
                      options.live_cell, Cause::kExists});
  if (writes_cell) require_writable(options.live_cell, "cell");
  heed_interrupts();
  ServedCell served(request);
  if (writes_cell) write_file(options.live_cell, served.live_text());
  tell(fmt::format("serving {} until interrupted{}", options.cell.string(),
                   writes_cell
                       ? fmt::format("; {} describes it as a real cell", options.live_cell.string())
                       : ""));
  tell(served.description());
  for (LineReader input(STDIN_FILENO); !interrupted(); served.require_well()) {
    if (const auto line = input.next(kInputPeriod_s))
      tell(served.obey(*line));
    else if (input.ended())
      SteadyClock().sleep_for_s(kInputPeriod_s);
  }
  return {};
}

/// Returns a plate with these marks on it and a margin around them.
WorkpieceTruth plate_with(const std::vector<Fiducial>& marks) {
  constexpr double kMargin_m = 0.010;
  WorkpieceTruth work;
  work.plate_from_m = work.plate_to_m = marks.front().p_W;
  for (const Fiducial& mark : marks) {
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(0.5 * mark.size + kMargin_m);
    work.plate_from_m = work.plate_from_m.cwiseMin(mark.p_W - reach);
    work.plate_to_m = work.plate_to_m.cwiseMax(mark.p_W + reach);
    work.marks.push_back({value_named(kMarkShapes, name_in(kFiducialKinds, mark.kind)).value(),
                          mark.p_W, mark.size, tag_number(mark.id).value_or(0)});
  }
  return work;
}

Outcome put(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  if (!cell.truth) throw InputError({"is no virtual cell", "name one", options.cell});
  if (!options.slide.empty() && options.slide[0] < 0.0)
    throw InputError(
        {fmt::format("is {:g}", options.slide[0]), "0 s or later is needed", "AT_S of --slide"});
  const std::vector<Fiducial> marks = read_work_drawing(options.drawing);
  Truth truth = read_truth(*cell.truth);
  WorkpieceTruth work = plate_with(marks);
  work.p_BW = Eigen::Vector3d(options.at[0], options.at[1], options.higher_mm) * kMillimetre;
  work.p_BW.z() += marks.front().z + truth.tool.lamp_height_m;
  work.turn_rad = options.at[2] * kDegree;
  if (!options.slide.empty())
    work.slide = SlideTruth{options.slide[0],
                            Eigen::Vector2d(options.slide[1], options.slide[2]) * kMillimetre,
                            options.slide[3] * kDegree};
  truth.works.push_back(work);
  write_truth(*cell.truth, truth);
  say("put a work with {} marks into {}, its origin at {}\n", marks.size(), cell.truth->string(),
      place_mm(work.p_BW.head<2>()));
  return {{{"marks", marks.size()}, {"truth", cell.truth->string()}}};
}

Outcome work(const Options& options) {
  if (!options.drawing.empty()) return put(options);
  return options.cell.empty() ? draw(options) : serve(options);
}

void add_serve_options(CLI::App& server, Options& options) {
  add_required(server, "--cell", options.cell, "cell.yaml", "the virtual cell");
  add_value(server, "--out", options.live_cell, "live.yaml",
            "a cell file to be written, which describes the served devices as real ones");
  server.add_option("--address", options.address, "an address of this machine")
      ->capture_default_str();
  add_choice(server, "--tracker", options.tracker, {kTcp, kFile},
             "the tracker's lines come from port 7701, or in tracker.txt beside the cell");
  add_value(server, "--tracker-clock", options.tracker_clock, "OFFSET_S,PPM",
            "seconds by which the tracker's clock is ahead of this computer's, and parts in a "
            "million by which it runs fast")
      ->delimiter(',')
      ->expected(2);
  server.add_flag("--decimal-comma", options.decimal_comma,
                  "the tracker writes 1,5 for 1.5, and ; between columns");
  add_value(server, "--broken-beams", options.broken_percent, "PERCENT",
            "share of the time in which the tracker's beam is broken, and nothing sent, for 6 "
            "s at a time");
  add_value(server, "--truth-log", options.truth_log, "FILE",
            "where the tool really is, whenever it has moved; for scoring only");
  add_value(server, "--grbl-firmware", options.firmware, "PROGRAM",
            "the simulator of Grbl 1.1, which is the drives' board instead of an emulated "
            "one; it has no home switches");
  server
      .add_flag("--shafts", options.shafts,
                "the motors follow the lines of three counts that any program writes into the pipe "
                "shafts beside the cell")
      ->excludes("--grbl-firmware");
}

void add_put_options(CLI::App& command, Options& options) {
  constexpr double kFarthest_mm = 1e5;
  add_required(command, "--cell", options.cell, "cell.yaml", "the virtual cell");
  add_required(command, "--drawing", options.drawing, "work.csv", "the marks of the work");
  add_required(command, "--at", options.at, "X,Y,TURN",
               "where its origin lies and how it is turned, mm and deg")
      ->delimiter(',')
      ->expected(3)
      ->check(within(-kFarthest_mm, kFarthest_mm));
  add_value(command, "--higher-mm", options.higher_mm, "H",
            "by how much it lies higher than the drawing's z_mm says")
      ->check(within(-kFarthest_mm, kFarthest_mm));
  add_value(command, "--slide", options.slide, "AT_S,DX,DY,TURN",
            "when it slides, by how much, and turns")
      ->delimiter(',')
      ->expected(4)
      ->check(within(-kFarthest_mm, kFarthest_mm));
}

void add_options(CLI::App& app, Options& options) {
  app.require_subcommand(1);
  app.fallthrough();
  add_serve_options(*app.add_subcommand(
                        kServe.name,
                        "Serves a cell as real devices of this machine until interrupted: a GigE "
                        "Vision camera, drives on a Grbl board, a tracker. Lines on standard input "
                        "say what a person would do at the cell: " +
                            std::string(kCellCommands) + ". When they end, the cell runs on."),
                    options);
  add_put_options(*app.add_subcommand(kPut.name, "Puts a workpiece into a virtual cell's truth."),
                  options);
  CLI::App* command = app.add_subcommand(kDraw.name, "Draws a new random cell with its truth.");
  command->add_option("--seed", options.seed, "the same seed draws the same cell")->required();
  add_choice(*command, "--like", options.like, names_of(kCellKinds),
             "the kind of cell: the paper's; one whose arm and readings have what the "
             "estimators' models lack; one that warms, with fixed lamps; one with an "
             "ordinary or a cheap real arm");
  add_required(*command, "-o,--out", options.folder, "DIR", "folder for cell.yaml and truth.yaml");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::work);
}
