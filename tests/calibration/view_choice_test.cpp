#include "planar_servo/calibration/view_choice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "calibration/board_image.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

const Board kSquareBoard{Board::Kind::kCircles, 11, 11, 0.01};
const Board kLongBoard{Board::Kind::kCircles, 11, 7, 0.01};
const cv::Size kPicture(1200, 900);
/// With the focal length that board_stance() takes for usual.
const Pinhole kUsualCamera{{1800.0, 1800.0, 599.5, 449.5}};

std::vector<Eigen::Vector2d> pixels_of(const CameraModel& camera, const Board& board,
                                       const Pose& X_CG) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& p : board_points(board))
    pixels.push_back(project(camera, X_CG * Eigen::Vector3d(p.x(), p.y(), 0.0)).value());
  return pixels;
}

/// A board tilted so that its edge in this direction of the picture is nearer, its middle shifted
/// by shares of the picture.
BoardStance stance_of(const Board& board, double tilt, double towards, double turn = 0.0,
                      const Eigen::Vector2d& shift = {0.0, 0.0}, double distance = 0.4) {
  // A turn about the image's x axis brings the upper edge nearer.
  Pose X_CG = test::board_before_camera(board, distance, tilt, towards + kPi / 2.0, turn);
  X_CG.translation().x() += shift.x() * kPicture.width / 1800.0 * distance;
  X_CG.translation().y() += shift.y() * kPicture.height / 1800.0 * distance;
  return board_stance(board, pixels_of(kUsualCamera, board, X_CG), kPicture).value();
}

TEST_CASE("The stance of a board is its place, size, tilt towards the camera and turn") {
  for (const double towards : {0.0, 1.0, 2.0, -2.5, -0.7})
    for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(-0.2, 0.2)}) {
      const BoardStance stance = stance_of(kSquareBoard, 0.3, towards, 0.2, shift);
      const Eigen::Vector2d expected = 0.3 * rotation2d(towards).col(0);
      CHECK((stance.tilt - expected).norm() < 0.03);
      CHECK((stance.middle - shift - Eigen::Vector2d(0.5, 0.5)).norm() < 0.01);
      CHECK(std::abs(stance.turn - 0.2) < 0.06);
    }
  const BoardStance flat = stance_of(kSquareBoard, 0.0, 0.0);
  CHECK(flat.tilt.norm() < 1e-6);
  // Ten pitches of 10 mm at 0.4 m are 450 pixels long.
  CHECK(std::abs(flat.size - 450.0 / std::sqrt(1200.0 * 900.0)) < 1e-6);
  const std::vector<Eigen::Vector2d> on_a_line(121, Eigen::Vector2d(5.0, 7.0));
  CHECK_FALSE(board_stance(kSquareBoard, on_a_line, kPicture));
}

TEST_CASE("A board reaches a corner of the picture when a dot lies in the outer sixth") {
  const BoardStance middle = stance_of(kSquareBoard, 0.0, 0.0);
  CHECK(middle.reaches_corner == std::array<bool, 4>{});
  const BoardStance upper_left = stance_of(kSquareBoard, 0.0, 0.0, 0.0, {-0.22, -0.22});
  CHECK(upper_left.reaches_corner == std::array<bool, 4>{true, false, false, false});
  const BoardStance lower_right = stance_of(kSquareBoard, 0.0, 0.0, 0.0, {0.22, 0.22});
  CHECK(lower_right.reaches_corner == std::array<bool, 4>{false, false, true, false});
}

TEST_CASE("A turn counts up to what the board's shape can tell") {
  const BoardStance quarter = stance_of(kSquareBoard, 0.0, 0.0, 0.1);
  CHECK(alike(Purpose::kHeldBoard, quarter, stance_of(kSquareBoard, 0.0, 0.0, 0.1 + kPi / 2.0)));
  CHECK_FALSE(alike(Purpose::kHeldBoard, quarter, stance_of(kSquareBoard, 0.0, 0.0, 0.1 + 0.6)));
  const BoardStance level = stance_of(kLongBoard, 0.0, 0.0, 0.1);
  CHECK_FALSE(alike(Purpose::kHeldBoard, level, stance_of(kLongBoard, 0.0, 0.0, 0.1 + kPi / 2.0)));
  CHECK(wrap_to_period(1.0, 1.5) == Approx(-0.5));
  CHECK(wrap_to_period(-0.75, 1.5) == Approx(0.75));
}

TEST_CASE(
    "Views are alike when place, size, tilt and turn are, and of laid boards tilt does not count") {
  const BoardStance base = stance_of(kSquareBoard, 0.3, 0.0);
  CHECK(alike(Purpose::kHeldBoard, base, stance_of(kSquareBoard, 0.33, 0.05, 0.05, {0.02, 0.0})));
  const BoardStance others[] = {stance_of(kSquareBoard, 0.3, 0.0, 0.0, {0.1, 0.0}),
                                stance_of(kSquareBoard, 0.3, 0.0, 0.0, {0.0, 0.0}, 0.48),
                                stance_of(kSquareBoard, 0.1, 0.0),
                                stance_of(kSquareBoard, 0.3, 0.0, 0.4)};
  for (const BoardStance& other : others) CHECK_FALSE(alike(Purpose::kHeldBoard, base, other));
  CHECK(alike(Purpose::kLaidBoard, base, stance_of(kSquareBoard, 0.1, 0.0)));
}

TEST_CASE("What is asked for next is what no view has shown") {
  ViewChoice choice(Purpose::kHeldBoard);
  CHECK(choice.missing().size() == 8);
  CHECK(choice.request() ==
        "move it into the upper left corner of the picture, or tilt its left edge towards the "
        "camera by 20 degrees");
  choice.take("v0", stance_of(kSquareBoard, 0.35, kPi, 0.0, {-0.22, -0.22}));
  CHECK(choice.request() ==
        "move it into the upper right corner of the picture, or tilt its right edge towards the "
        "camera by 20 degrees");
  choice.take("v1", stance_of(kSquareBoard, 0.35, 0.0, 0.0, {0.22, -0.22}));
  choice.take("v2", stance_of(kSquareBoard, 0.35, kPi / 2.0, 0.0, {0.22, 0.22}));
  choice.take("v3", stance_of(kSquareBoard, 0.35, -kPi / 2.0, 0.0, {-0.22, 0.22}));
  CHECK(choice.missing().empty());
  CHECK(choice.request() == "any place, tilt or turn unlike those taken");
}

TEST_CASE("The views left go to what is missing, and only spare ones may show anything new") {
  ViewChoice choice(Purpose::kHeldBoard);
  const BoardStance plain = stance_of(kSquareBoard, 0.0, 0.0);
  CHECK(choice.worth(plain, 5) == ViewWorth::kNew);
  CHECK(choice.worth(plain, 4) == ViewWorth::kUnneeded);
  CHECK(choice.worth(stance_of(kSquareBoard, 0.35, 0.0), 4) == ViewWorth::kNew);
  choice.take("v0", plain);
  CHECK(choice.worth(plain, 5) == ViewWorth::kLikeTaken);
  CHECK(choice.like(plain) == "v0");
}

TEST_CASE("Laid boards are asked for in the middle first, then at the corners and turned") {
  ViewChoice choice(Purpose::kLaidBoard);
  CHECK(choice.request() == "lay it into the middle of the picture, its rows along the picture's");
  CHECK(choice.open_corners().empty());
  CHECK(choice.worth(stance_of(kSquareBoard, 0.0, 0.0, kPi / 4.0), 1) == ViewWorth::kUnneeded);
  choice.take("l0", stance_of(kSquareBoard, 0.0, 0.0));
  CHECK(choice.missing().size() == 5);
  CHECK(choice.open_corners().size() == 4);
  choice.take("l1", stance_of(kSquareBoard, 0.0, 0.0, kPi / 4.0, {-0.2, -0.2}));
  CHECK(choice.request() == "move it into the upper right corner of the picture");
}

TEST_CASE("No two views that are taken are alike, and their order does not matter") {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const Purpose plan : {Purpose::kHeldBoard, Purpose::kLaidBoard}) {
    ViewChoice choice(plan);
    std::vector<BoardStance> taken;
    for (int i = 0; i < 400; ++i) {
      const BoardStance stance =
          stance_of(kSquareBoard, uniform(0.0, 0.5), uniform(-kPi, kPi), uniform(-0.7, 0.7),
                    {uniform(-0.2, 0.2), uniform(-0.2, 0.2)}, uniform(0.4, 0.6));
      if (choice.worth(stance, 1000) != ViewWorth::kNew) continue;
      for (const BoardStance& other : taken) REQUIRE_FALSE(alike(plan, other, stance));
      choice.take(std::to_string(i), stance);
      taken.push_back(stance);
    }
    CHECK(taken.size() > 10);
    std::shuffle(taken.begin(), taken.end(), random);
    ViewChoice other(plan);
    for (const BoardStance& stance : taken) other.take("v", stance);
    CHECK(other.request() == choice.request());
    for (int i = 0; i < 100; ++i) {
      const BoardStance stance = stance_of(kSquareBoard, uniform(0.0, 0.5), uniform(-kPi, kPi));
      CHECK(other.worth(stance, 3) == choice.worth(stance, 3));
    }
  }
}

TEST_CASE("A board stands still while all its dots stay within the bound") {
  BoardRest rest(2.0);
  const auto at = [](double u) { return std::vector<Eigen::Vector2d>(4, {u, 0.0}); };
  CHECK(rest.still_for_s() == 0.0);
  for (int i = 0; i <= 10; ++i) rest.see(0.1 * i, at(i % 2));
  CHECK(rest.still_for_s() == Approx(1.0));
  rest.see(1.1, at(20.0));
  CHECK(rest.still_for_s() == 0.0);
  // A board that creeps by 1 px in 0.1 s has moved by at most 2 px for 0.2 s.
  for (int i = 1; i <= 10; ++i) rest.see(1.1 + 0.1 * i, at(20.0 + i));
  CHECK(rest.still_for_s() == Approx(0.2));
  rest.see(2.2, {});
  CHECK(rest.still_for_s() == 0.0);
}

}  // namespace
}  // namespace planar
