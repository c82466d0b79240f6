#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/calibration/board.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/offline/calibrate_camera.h"

namespace planar {

/// Says how a cell's vision is calibrated and how its loop is closed.
struct ChainSettings {
  std::string name;          ///< also names the folder that takes the chain's files
  std::string camera_model;  ///< one of calibration_model_names()
  CenterMethod center{CenterMethod::kAuto};
  bool plane_from_board{false};  ///< takes the plane from a board laid on it, else from the pairs
  bool learns_map{true};         ///< an error map; else vision is taken as it is
  /// Takes a Gaussian without ridge whose width is turned by hand on the test positions.
  bool hand_width{false};
  /// Learns the error at the lamps, together with the arm, and aims with the arm that was found.
  bool field_at_lamps{false};
  /// Else plane and scale are the board's, place and turn the arm's, and only unattended poses and
  /// the sweep of joint 1 are used.
  bool uses_tracker{true};
  /// Height of the laid boards' dots above the lamps' plane, metres. With it the lays tell the
  /// field at the lamps, too.
  std::optional<double> dots_height{};
  /// Checks before the first target that the cell is as it was, stops the arm where a look
  /// contradicts the calibration, and refuses an error map that its own fit rejects.
  bool is_guarded{true};
  /// Positions by all looks at a target; else the whole error of the last look is corrected.
  bool estimates_landings{true};
  bool accept_step{false};  ///< uses pairs between which something seems to have moved
  bool accept_map{false};   ///< moves by an error map that its fit rejects
  ServoSettings servo;
};

/// Returns our chain, which makes every choice by held-out or leave-one-out error and has the
/// cell's own servo settings.
ChainSettings our_chain(const CellSettings& cell);

/// Returns the paper's chain: one radial coefficient, Canny and Kasa, the plane from a board, a
/// width by hand, and its inverse law with single frames from wherever the arm comes.
ChainSettings paper_chain(const CellSettings& cell);

/// Returns a chain of what ViSP brings: vpCalibration's camera model, vpDot2's centres and
/// vpServo's law. ViSP has no error map; the plane is from a board as in the paper's chain, and so
/// is how it approaches and looks.
ChainSettings visp_chain(const CellSettings& cell);

/// Holds what was recorded, read once for every chain.
struct RecordedCell {
  std::filesystem::path folder;
  std::vector<FrameRow> frames;
  std::vector<TrackerRow> tracker;
  Board board;
  BoardViews boards;  ///< views of the board held into the view
};

/// Reads a recording. Throws InputError when it lacks a table.
RecordedCell read_recorded_cell(const std::filesystem::path& recording, const Board& board);

/// Holds a chain calibrated from what was recorded only. Its files are in `folder`, as the programs
/// write them, and `cell` names them.
struct CalibratedChain {
  ChainSettings settings;
  std::filesystem::path folder;
  CellSettings cell;
  std::vector<PairRow> pairs;
  /// At the end point, as the paper's tables judge maps; none without a tracker or where none is
  /// learned.
  std::optional<MapResult> map;
  std::optional<LampFieldFit> field{};  ///< what the loop uses instead, where there is one
};

/// Calibrates a chain from a recording and writes its files to `folder/name`.
CalibratedChain calibrate_chain(const ChainSettings& settings, const CellSettings& cell,
                                const RecordedCell& recorded, const std::filesystem::path& folder);

}  // namespace planar
