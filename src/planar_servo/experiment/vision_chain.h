#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/board/board.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/error_map/fit_error_map.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/camera/calibrate_camera.h"

namespace planar {

/// How a cell's vision is calibrated and its loop closed.
struct ChainSettings {
  std::string name;          ///< also the name of the folder that takes the chain's files
  std::string camera_model;  ///< of calibration_model_names()
  CenterMethod center{CenterMethod::kAuto};
  bool plane_from_board{false};  ///< the plane from a board laid on it, else from the pairs
  bool hand_width{false};  ///< a Gaussian width turned by hand on the test positions, no ridge
  ServoSettings servo;
};

/// Ours: every choice by held-out or leave-one-out error, the cell's own servo settings.
ChainSettings our_chain(const CellSettings& cell);

/// The paper's: one radial coefficient, Canny and Kasa, the plane from a board, a width by hand,
/// its inverse law with single frames from wherever the arm comes.
ChainSettings paper_chain(const CellSettings& cell);

/// What was recorded, read once for every chain.
struct RecordedCell {
  std::filesystem::path folder;
  std::vector<FrameRow> frames;
  std::vector<TrackerRow> tracker;
  Board board;
  BoardViews boards;  ///< the board held into the view
};

/// Throws InputError when the recording lacks a table.
RecordedCell read_recorded_cell(const std::filesystem::path& recording, const Board& board);

/// A chain calibrated from what was recorded only. Its files stand in `folder/name` as the programs
/// write them, and `cell` names them.
struct CalibratedChain {
  ChainSettings settings;
  CellSettings cell;
  CameraCalibration camera;
  std::vector<PairRow> pairs;
  MapResult map;
};

CalibratedChain calibrate_chain(const ChainSettings& settings, const CellSettings& cell,
                                const RecordedCell& recorded, const std::filesystem::path& folder);

}  // namespace planar
