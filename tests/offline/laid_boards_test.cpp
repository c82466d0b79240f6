#include "planar_servo/offline/pairs/laid_boards.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "support/refused.h"

namespace planar {
namespace {

constexpr double kDotDiameter = 0.020;
constexpr double kExactlySeen = 1e-9;  // m

/// The pose in W of a board that lies `height` above the lamps' plane, seen from above.
Pose board_lying(const Eigen::Vector2d& place, double turn, double height) {
  Pose X_WG = Pose::Identity();
  X_WG.linear() = rotation_from_vector({0.0, 0.0, turn}) * rotation_from_vector({kPi, 0.0, 0.0});
  X_WG.translation() << place, height;
  return X_WG;
}

/// What a picture without noise shows of a board at this pose; its own pose is in the board's unit.
LaidBoard laid_at(const test::SyntheticCell& cell, const Pose& X_WG, const Board& board,
                  double pitch) {
  LaidBoard laid{"lay", cell.X_WC_ref.inverse() * X_WG, board, {}};
  for (const Eigen::Vector2d& unit : board_points(board)) {
    const Eigen::Vector2d p_G = unit * pitch / board.pitch;
    const Eigen::Vector3d p_C = laid.X_CG * Eigen::Vector3d(p_G.x(), p_G.y(), 0.0);
    laid.sight.pixels.push_back(project(cell.lens, p_C).value() +
                                eccentricity_px(cell.lens, laid.X_CG, p_G, kDotDiameter).value());
    const double of_1px2 = disc_diameter(cell.lens, laid.X_CG, p_G, 1.0).value();
    laid.sight.dot_areas_px2.push_back(std::pow(kDotDiameter / of_1px2, 2));
    laid.sight.dot_sigmas_px.push_back(0.01);
  }
  laid.X_CG.translation() *= board.pitch / pitch;
  return laid;
}

}  // namespace

TEST_CASE("The dots of a laid board are seen where they lie, at the height that is stated") {
  const test::SyntheticCell cell;
  const Board board = parse_board("circles:5x4:50mm");
  const double height = -5.5 * kMillimetre, turn = 2.2;
  const Eigen::Vector2d place(0.15, -0.2);
  const LaidBoard laid = laid_at(cell, board_lying(place, turn, height), board, board.pitch);
  const std::vector<LayRow> rows = seen_lays(cell.workplane(), {laid}, height);
  REQUIRE(rows.size() == 20);
  for (const LayRow& row : rows) {
    CHECK((row.p_seen - (place + rotation2d(turn) * row.p_board)).norm() < kExactlySeen);
    CHECK(row.sigma == Approx(0.01 * 1.25 / 4200.0).epsilon(0.2));
    CHECK(row.pitch_known);
    CHECK(row.lay == "lay");
  }
  const LayRow unstated = seen_lays(cell.workplane(), {laid}, 0.0).back();
  CHECK((unstated.p_seen - rows.back().p_seen).norm() > 0.5 * kMillimetre);
}

TEST_CASE("A board of unknown pitch is seen in the same places and says that it is not known") {
  const test::SyntheticCell cell;
  const Pose X_WG = board_lying({-0.1, 0.1}, 0.3, 0.0);
  const Board known = parse_board("circles:5x4:50mm");
  const Board unknown = parse_board("circles:5x4:?", BoardUse::kShape);
  const auto rows = seen_lays(cell.workplane(), {laid_at(cell, X_WG, known, 0.05)}, 0.0);
  const auto shapes = seen_lays(cell.workplane(), {laid_at(cell, X_WG, unknown, 0.05)}, 0.0);
  REQUIRE(shapes.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CHECK((shapes[i].p_seen - rows[i].p_seen).norm() < kExactlySeen);
    CHECK((50.0 * shapes[i].p_board - rows[i].p_board).norm() < kExactlySeen);
    CHECK_FALSE(shapes[i].pitch_known);
  }
}

TEST_CASE("Boards seen in another size than they have are doubted, all or the one that lies off") {
  const test::SyntheticCell cell;
  const Board board = parse_board("circles:5x4:50mm");
  const double camera_height = cell.X_WC_ref.translation().z();
  std::vector<LaidBoard> boards;
  for (const double turn : {0.0, 1.0, 2.0}) {
    boards.push_back(laid_at(cell, board_lying({0.1, -0.1 * turn}, turn, 0.0), board, board.pitch));
    boards.back().lay = fmt::format("lay_{:.0f}", turn);
  }
  const auto doubts = [&](double stated_height) {
    return doubts_of_lays(seen_lays(cell.workplane(), boards, stated_height),
                          camera_height - stated_height);
  };
  CHECK(doubts(0.0).empty());
  CHECK(doubts(0.0005).empty());
  REQUIRE(doubts(0.0055).size() == 1);
  CHECK(doubts(0.0055)[0].cause == Cause::kContradiction);
  CHECK_THAT(doubts(0.0055)[0].fault, Catch::Contains("5.5 mm below"));
  boards[1] = laid_at(cell, board_lying({0.1, -0.1}, 1.0, 0.003), board, board.pitch);
  REQUIRE(doubts(0.0).size() == 1);
  CHECK_THAT(doubts(0.0)[0].fault,
             Catch::Contains("'lay' is seen as if it lay 3.0 mm above the others"));
  for (LaidBoard& laid : boards) laid.board.pitch_known = false;
  CHECK(doubts(0.0055).empty());
}

TEST_CASE("A chessboard has no dots to be seen") {
  const test::SyntheticCell cell;
  const Board board = parse_board("chessboard:5x4:50mm");
  const LaidBoard laid{"lay", Pose::Identity(), board, {}};
  CHECK_THROWS_MATCHES(seen_lays(cell.workplane(), {laid}, 0.0), InputError,
                       test::Refused(Cause::kInvalid, "chessboard"));
}

}  // namespace planar
