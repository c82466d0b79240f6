#include "planar_servo/virtual_cell/virtual_sheets.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

const cv::Size kSensor(5120, 5120);
constexpr int kViews = 15;
constexpr int kLays = 20;

}  // namespace

TEST_CASE("Every dot of every view lies wholly within the sensor") {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const Truth truth = draw_truth(seed);
    const VirtualLens lens(truth.camera);
    VirtualBoard board(truth, lens, kSensor);
    for (int view = 0; view < kViews + kLays; ++view) {
      if (view < kViews)
        board.hold_board(view);
      else
        board.lay_board(view - kViews);
      const auto dots = board.dot_outlines_px(0.0);
      REQUIRE(dots.size() == 121);
      bool inside = true;
      for (const auto& dot : dots)
        for (const Eigen::Vector2d& uv : dot)
          inside = inside && uv.minCoeff() > 1.0 && uv.maxCoeff() < 5118.0;
      CHECK(inside);
    }
  }
}

TEST_CASE("Twelve views put dots into every eighth of the field's width and height") {
  const Truth truth = draw_truth(4);
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  std::set<std::pair<int, int>> tiles;
  for (int view = 0; view < 12; ++view) {
    board.hold_board(view);
    for (const auto& dot : board.dot_outlines_px(0.0))
      tiles.insert(
          {static_cast<int>(dot.front().x()) / 640, static_cast<int>(dot.front().y()) / 640});
  }
  CHECK(tiles.size() == 64);
}

TEST_CASE("Held boards are tilted and above the plane, laid boards lie on it") {
  const Truth truth = draw_truth(5);
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  double greatest_tilt = 0.0;
  for (int view = 0; view < kViews; ++view) {
    board.hold_board(view);
    const double tilt = std::acos(board.X_BG()->linear()(2, 2));
    greatest_tilt = std::max(greatest_tilt, tilt);
    CHECK(tilt < 30.0 * kDegree);
    CHECK(tilt > 1.0 * kDegree);
    CHECK(board.X_BG()->translation().z() >= 0.05);
    CHECK(board.X_BG()->translation().z() <= 0.35);
    for (const double x : {-0.25, 0.25})
      for (const double y : {-0.25, 0.25})
        CHECK((*board.X_BG() * Eigen::Vector3d(x, y, 0.0)).z() > 0.0);
  }
  CHECK(greatest_tilt > 15.0 * kDegree);
  board.lay_board(0);
  CHECK((*board.X_BG() * Eigen::Vector3d(0.25, 0.25, 0.0)).z() == 0.0);
  CHECK(board.X_BG()->linear()(2, 2) == 1.0);
}

TEST_CASE("The first board is laid where it has always been, the others anywhere at any turn") {
  const Truth truth = draw_truth(7);
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  board.lay_board(0);
  const Eigen::Vector3d first = board.X_BG()->translation();
  CHECK(first.x() == Approx(0.0109113579).epsilon(1e-8));
  CHECK(first.y() == Approx(0.0349536322).epsilon(1e-8));
  std::set<int> sixths_of_turn, sides;
  for (int view = 1; view < kLays; ++view) {
    board.lay_board(view);
    const Pose& X_BG = *board.X_BG();
    CHECK(X_BG.linear()(2, 2) == Approx(1.0).epsilon(1e-12));
    CHECK(X_BG.translation().z() == 0.0);
    const double turn = std::atan2(X_BG.linear()(1, 0), X_BG.linear()(0, 0));
    sixths_of_turn.insert(static_cast<int>(std::floor(turn / (kPi / 3.0))));
    const Eigen::Vector2d from_middle = (X_BG.translation() - lens.p_BC()).head<2>();
    if (from_middle.norm() > 0.1)
      sides.insert((from_middle.x() > 0.0 ? 1 : 0) + (from_middle.y() > 0.0 ? 2 : 0));
  }
  CHECK(sixths_of_turn.size() == 6);
  CHECK(sides.size() == 4);
}

TEST_CASE("A board too large to be seen whole is laid at the camera's foot") {
  Truth truth = draw_truth(7);
  truth.board.pitch_m = 0.2;
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  board.lay_board(1);
  CHECK((board.X_BG()->translation() - lens.p_BC()).head<2>().norm() == 0.0);
}

TEST_CASE("Views repeat for a seed and differ from each other and between seeds") {
  const auto pose = [](std::uint32_t seed, int view) {
    const Truth truth = draw_truth(seed);
    const VirtualLens lens(truth.camera);
    VirtualBoard board(truth, lens, kSensor);
    board.hold_board(view);
    return board.X_BG()->matrix().eval();
  };
  CHECK(pose(1, 0) == pose(1, 0));
  CHECK(pose(1, 0) != pose(1, 9));
  CHECK(pose(1, 0) != pose(2, 0));
}

TEST_CASE("A rendered board is bright, its dots dark, the rest of the sensor untouched") {
  const Truth truth = draw_truth(6);
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  CHECK_FALSE(board.render(0.0));
  board.lay_board(1);
  const Light light = *board.render(0.0);
  const auto level_at = [&](const Eigen::Vector2d& p_G) {
    const Eigen::Vector2d uv =
        *lens.project(*board.X_BG() * Eigen::Vector3d(p_G.x(), p_G.y(), 0.0), 0.0);
    const cv::Point pixel(static_cast<int>(std::lround(uv.x())),
                          static_cast<int>(std::lround(uv.y())));
    return light.levels(pixel - light.window_px.tl());
  };
  constexpr double kFloat = 1e-3;  // grey levels, after coverage and blur in floats
  CHECK(level_at({0.0, 0.0}) == Approx(truth.board.dark_level).margin(kFloat));
  CHECK(level_at({0.25, -0.25}) == Approx(truth.board.dark_level).margin(kFloat));
  CHECK(level_at({0.025, 0.025}) == Approx(truth.board.bright_level).margin(kFloat));
  CHECK(light.levels(0, 0) == Approx(0.0).margin(kFloat));
  board.remove_board();
  CHECK_FALSE(board.render(0.0));
}

TEST_CASE("VirtualBoard refuses a negative view") {
  const Truth truth = draw_truth(1);
  const VirtualLens lens(truth.camera);
  VirtualBoard board(truth, lens, kSensor);
  CHECK_THROWS_AS(board.hold_board(-1), std::invalid_argument);
  CHECK_THROWS_AS(board.lay_board(-1), std::invalid_argument);
}

}  // namespace planar
