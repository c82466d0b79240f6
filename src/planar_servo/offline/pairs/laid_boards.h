#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/geometry/lens/camera_model.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar {

/// A board laid on the plane, as one picture shows it.
struct LaidBoard {
  std::string lay;  ///< name of its image
  Pose X_CG{Pose::Identity()};
  Board board;
  BoardSight sight;
};

/// Finds the board in the recording's frames of plan plane_grid. Throws InputError when there is no
/// such frame, and naming each image that cannot be read or in which the board is not found.
std::vector<LaidBoard> boards_on_plane(const std::filesystem::path& recording,
                                       const std::vector<FrameRow>& frames,
                                       const CameraModel& camera, const Board& board);

/// Returns where the centres of the boards' dots are seen when they lie `dots_height` above the
/// lamps' plane (metres, negative below), the eccentricity of their images taken off. A dot whose
/// ray does not meet that plane is left out. Throws InputError for a chessboard, which has no dots.
std::vector<LayRow> seen_lays(const Workplane& workplane, const std::vector<LaidBoard>& boards,
                              double dots_height);

/// Returns doubts where boards of known pitch are seen in another size than they have:
/// one when all seem to lie off the height that was stated, and one for each that seems to lie off
/// the others. The camera is this far above the dots' plane, metres.
std::vector<Refusal> doubts_of_lays(const std::vector<LayRow>& lays, double camera_height);

}  // namespace planar
