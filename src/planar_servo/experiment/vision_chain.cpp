#include "planar_servo/experiment/vision_chain.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/offline/locate_lamps.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/map/learn_lamp_field.h"
#include "planar_servo/offline/pairs/health_of_recording.h"
#include "planar_servo/offline/pairs/laid_boards.h"
#include "planar_servo/offline/pairs/pair_files.h"
#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr char kProgram[] = "planar-experiment";

// The range of widths that a hand tries, and their number.
constexpr double kHandWidthFrom = 20.0 * kMillimetre;
constexpr double kHandWidthTo = 320.0 * kMillimetre;
constexpr int kHandWidths = 25;

constexpr char kViSPModel[] = "visp";  // which has a file format of its own

CellSettings with_files_in(CellSettings cell, const fs::path& folder, const ChainSettings& chain) {
  cell.camera_model = folder / (chain.camera_model == kViSPModel ? "camera.xml" : "camera.yaml");
  cell.workplane = folder / "workplane.yaml";
  cell.tool = folder / "tool.yaml";
  cell.error_map = folder / "map.yaml";
  cell.health = folder / "health.yaml";
  return cell;
}

/// Returns the frames that a chain is calibrated from: without a tracker those that watch the arm
/// alone, poses and the sweep of joint 1; without a map all but those that only judge maps.
std::vector<FrameRow> frames_for(const ChainSettings& settings, std::vector<FrameRow> frames) {
  const auto unused = [&](const FrameRow& frame) {
    if (!settings.uses_tracker)
      return frame.plan != Purpose::kPose && frame.plan != Purpose::kSweep1;
    return !settings.learns_map && (frame.plan == Purpose::kTest || frame.plan == Purpose::kCheck);
  };
  frames.erase(std::remove_if(frames.begin(), frames.end(), unused), frames.end());
  return frames;
}

CameraModel make_camera(const ChainSettings& settings, const CellSettings& cell,
                        const RecordedCell& recorded) {
  CalibrationProblem problem = recorded.boards.problem;
  problem.model = settings.camera_model;
  problem.leaves_views_out = settings.camera_model != kViSPModel;  // whose XML does not hold it
  const CameraCalibration calibration = calibrate_camera(problem, recorded.boards.rejected);
  write_camera(cell.camera_model, calibration, kProgram, recorded.boards.inputs);
  return calibration.camera;
}

std::vector<PairRow> make_pairs(const ChainSettings& settings, const CellSettings& cell,
                                const RecordedCell& recorded, const CameraModel& camera,
                                const fs::path& folder) {
  PairTrackerRequest request;
  request.cell = cell;
  request.camera = camera;
  request.frames = frames_for(settings, recorded.frames);
  const LocateReport located =
      locate_lamps_of_recording(cell, recorded.folder, request.frames, settings.center);
  request.lamps = located.rows;
  const RecordedTables tables{folder / "lamps.csv", recorded.folder / "frames.csv",
                              settings.uses_tracker ? recorded.folder / "tracker.csv" : ""};
  write_file(tables.lamps,
             lamps_text(request.lamps, lamp_remarks(origins_of_lamps(cell, tables.frames, false),
                                                    located.reference_lamps)));
  if (settings.uses_tracker) request.tracker = recorded.tracker;
  request.dots_height = settings.dots_height.value_or(0.0);
  const bool plane_from_board = settings.plane_from_board || !settings.uses_tracker;
  std::vector<LaidBoard> boards;
  if (plane_from_board || settings.dots_height)
    boards = boards_on_plane(recorded.folder, recorded.frames, camera, recorded.board);
  if (plane_from_board) request.boards_on_plane = boards;
  request.accept_step = settings.accept_step;
  const PairTrackerReport report = pair_tracker(request);
  const WorkplaneSource source =
      plane_from_board ? WorkplaneSource::kBoard : WorkplaneSource::kPairs;
  const PairFiles files{cell.workplane, cell.tool, folder / "pairs.csv"};
  write_pair_files(files, cell, tables, report.workplane, source, report.pairs, kProgram);
  const VisionCalibration vision{cell.lamps.layout, Workplane(camera, report.workplane.X_WC),
                                 report.workplane.tool};
  if (settings.dots_height)
    write_lays_file(folder / "lays.csv", cell, files, tables,
                    seen_lays(vision.workplane, boards, *settings.dots_height));
  write_health_file(*cell.health, cell, files,
                    health_of(cell, seen_places(cell, vision, request.frames, request.lamps)),
                    kProgram);
  return read_pairs(files.pairs);
}

/// Fits the map that a hand finds: the one of the width that is best on the test positions.
MapResult map_by_hand(const std::vector<PairRow>& pairs) {
  const std::vector<PairRow> judges = pairs_to_check(pairs, {Purpose::kTest});
  std::optional<MapResult> best;
  double best_rms = 0.0;
  for (int i = 0; i < kHandWidths; ++i) {
    const double width =
        kHandWidthFrom * std::pow(kHandWidthTo / kHandWidthFrom, i / (kHandWidths - 1.0));
    try {
      MapResult result = fit_error_map_to_pairs(pairs, {MapMethod::kHandWidth, width}).result;
      const double rms = check_error_map(result.map, judges).compensated.rms;
      if (best && !(rms < best_rms)) continue;
      best_rms = rms;
      best = std::move(result);
    } catch (const WorkError&) {
      break;  // wider Gaussians without a ridge are worse conditioned still
    }
  }
  if (!best)
    throw WorkError(
        "no width set by hand gives a map of these pairs: the equations cannot be solved",
        Cause::kInsufficient);
  return std::move(*best);
}

/// Learns the field at the lamps and the arm, and writes both files.
void learn_field(CalibratedChain& chain, const fs::path& folder) {
  LampFieldFiles files{folder / "pairs.csv", {}, chain.cell.error_map, folder / "arm.yaml"};
  if (chain.settings.dots_height) files.lays = folder / "lays.csv";
  chain.field = learn_lamp_field(files, chain.cell, read_vision(chain.cell, false));
  chain.cell.arm_found = files.arm;
  write_lamp_field(files, *chain.field, chain.cell, kProgram);
}

}  // namespace

ChainSettings our_chain(const CellSettings& cell) {
  ChainSettings chain;
  chain.name = "ours";
  chain.camera_model = "auto";
  chain.center = cell.lamps.method;
  chain.field_at_lamps = true;
  chain.servo = cell.servo;
  return chain;
}

ChainSettings paper_chain(const CellSettings& cell) {
  ChainSettings chain;
  chain.name = "paper";
  chain.camera_model = "plumb_bob_k1";
  chain.center = CenterMethod::kCannyKasa;
  chain.plane_from_board = true;
  chain.hand_width = true;
  chain.servo = cell.servo;
  chain.servo.law = ServoLaw::kInverse;
  chain.servo.approach = Approach::kDirect;
  chain.is_guarded = false;  // the paper has no such checks, and gear play would fail them
  chain.estimates_landings = false;
  chain.servo.frames_per_measurement = 1;
  return chain;
}

ChainSettings visp_chain(const CellSettings& cell) {
  ChainSettings chain = paper_chain(cell);
  chain.name = "visp";
  chain.camera_model = kViSPModel;
  chain.center = CenterMethod::kVpDot2;
  chain.hand_width = false;
  chain.learns_map = false;
  chain.servo.law = ServoLaw::kJacobian;
  return chain;
}

RecordedCell read_recorded_cell(const fs::path& recording, const Board& board) {
  return {recording, read_frames(recording), read_tracker(recording / "tracker.csv"), board,
          find_board_views({recording}, board)};
}

CalibratedChain calibrate_chain(const ChainSettings& settings, const CellSettings& cell,
                                const RecordedCell& recorded, const fs::path& folder) {
  const fs::path own_folder = folder / settings.name;
  make_folder(own_folder);
  CalibratedChain chain;
  chain.settings = settings;
  chain.folder = own_folder;
  chain.cell = with_files_in(cell, own_folder, settings);
  chain.cell.servo = settings.servo;
  // An experiment that is continued must see the lamps as the first time, without these.
  for (const MadeFile& file : calibration_files(chain.cell, true)) fs::remove(file.path);
  const CameraModel camera = make_camera(settings, chain.cell, recorded);
  chain.pairs = make_pairs(settings, chain.cell, recorded, camera, own_folder);
  if (!settings.learns_map) return chain;
  if (settings.hand_width)
    chain.map = map_by_hand(chain.pairs);
  else if (settings.uses_tracker)
    chain.map = fit_error_map_to_pairs(chain.pairs, {MapMethod::kAuto, 0.0}).result;
  if (settings.field_at_lamps)
    learn_field(chain, own_folder);
  else
    write_file(chain.cell.error_map,
               map_text(chain.map.value(), own_folder / "pairs.csv", kProgram));
  return chain;
}

}  // namespace planar
