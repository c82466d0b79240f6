#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

/// The largest square, sides along x and y of the base frame, at which a cell can position its
/// end point. Metres.
struct TestSquare {
  Eigen::Vector2d centre{0.0, 0.0};
  double side{0.0};
};

/// Says where a cell is examined. Base frame, metres.
struct TestPlaces {
  TestSquare square;
  double raster{0.0};  ///< the square's corners lie on a raster of this spacing
  double usable{1.0};  ///< share of the workspace's raster where the cell can position
  std::array<Eigen::Vector2d, 5> poses{};  ///< P1 to P5
  std::vector<Eigen::Vector2d> targets;    ///< spread over what is usable of the workspace
};

/// Returns the poses P1 to P5 of a square: its centre, and points on its diagonals a tenth of their
/// length from the corners, from the corner at least x and y anticlockwise [ISO 9283:1998, 6.8,
/// where the plane is the diagonal one of a cube].
std::array<Eigen::Vector2d, 5> square_poses(const TestSquare& square);

/// A square of a raster: its upper right corner and its side, in spacings.
struct RasterSquare {
  std::size_t column{0}, row{0}, side{0};
};

/// Returns the squares of a raster whose nodes are all free, the largest first; at most one for
/// each node at its upper right corner.
std::vector<RasterSquare> free_squares(const std::vector<std::vector<bool>>& free);

/// Returns where a cell is examined: places that the arm reaches within its workspace, that the
/// camera sees and where the error map is valid. The targets follow the sequence of Halton (bases 2
/// and 3), evenly over the area of the workspace's ring; they are in the order of their angle about
/// the base. The ways to poses and targets in their order are free. Throws InputError when there is
/// no square or there are fewer targets than wanted.
TestPlaces find_test_places(const CalibratedCell& cell, std::size_t targets);

/// Returns the name of a pose by its index: "P1".
std::string pose_name(std::size_t index);

/// The size of a certificate.
struct CertificateSize {
  int cycles{30};    ///< of the poses, and of the directions
  int targets{100};  ///< over the workspace; 95 % need 72 for an interval

  static constexpr int kLeastCycles{2}, kMostCycles{1000}, kMostTargets{10000};
};

/// Returns every move in its order: the cycles P1 to P5, each pose coming from the one before
/// it; then the cycles in which P1, P2 and P4 are approached from +x, -x, +y and -y; then the
/// targets. Each has its own id.
std::vector<CertificateMove> certificate_moves(const TestPlaces& places, int cycles);

/// Says which cell is certified, and where the files go.
struct CertificateRequest {
  ServoRequest servo;  ///< `resume` is not used: the same request continues with what there is
  CertificateSize size;
  ServoRun::Observer watch{};  ///< is called at every look; may be empty
};

struct CertificateRun {
  CertificateRequest request;
  TestPlaces places{};
  JudgeKind judge{JudgeKind::kTruth};
  std::vector<JudgedMove> moves{};
  std::vector<std::string> accepted{};  ///< objections to the cell's files
  std::string ended_by{};               ///< why no further move was made; empty when complete
};

/// Opens a cell's devices, or lends those that are open, by a pointer that owns nothing.
using OpenDevices = std::function<std::shared_ptr<CellDevices>(const CellSettings&)>;

/// Moves a cell through certificate_moves() and has the end of each judged. Each judged move is
/// appended to cycles.csv in servo.folder at once, beside steps.csv and results.csv of all moves;
/// the same request continues where they end. Throws InputError before anything moves when nobody
/// can judge the cell, when find_test_places() fails, and when the folder holds something else or a
/// certificate that was begun with other files, sizes or settings. Throws what ServoRun throws.
/// `progress`, which may be empty, is told of the moves that are there before the first one is
/// made, and of each.
CertificateRun run_certificate(
    const CertificateRequest& request, const OpenDevices& open,
    const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace planar
