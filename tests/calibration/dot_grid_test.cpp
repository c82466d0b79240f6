#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/board_image.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "support/refused.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using test::Refused;

/// Systematic part of the edge search on an unblurred picture with 36 grey steps at a rim.
constexpr double kCenterTolerance_px = 0.03;
/// The same, in OpenCV's anti-aliased drawing.
constexpr double kDrawnCenterTolerance_px = 0.1;

const Board kSmallBoard{Board::Kind::kCircles, 7, 5, 0.03};
constexpr double kDotDiameter = 0.018;

/// Largest distance between the centres found and the true centres of the dots' images.
double largest_center_error_px(const BoardSight& sight, const Pose& X_CG) {
  const CameraModel camera = test::small_camera();
  const auto points = board_points(kSmallBoard);
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p_C = X_CG * Eigen::Vector3d(points[i].x(), points[i].y(), 0.0);
    const Eigen::Vector2d center =
        *project(camera, p_C) + *eccentricity_px(camera, X_CG, points[i], kDotDiameter);
    largest = std::max(largest, (sight.pixels[i] - center).norm());
  }
  return largest;
}

TEST_CASE("Every dot of a tilted grid is found where it was drawn, in the board's order") {
  for (const double axis : {0.0, 0.8, 2.1}) {
    for (const double turn : {0.0, 0.6}) {
      const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.5, axis, turn);
      const cv::Mat image =
          test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG);
      const BoardSight sight = find_board(image, kSmallBoard);
      INFO(sight.reason);
      REQUIRE(sight.found());
      CHECK(largest_center_error_px(sight, X_CG) < kCenterTolerance_px);
    }
  }
}

TEST_CASE("Bright dots on dark ground are found too") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.3, 1.0, 0.1);
  const cv::Mat image =
      test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG, {210.0, 25.0});
  const BoardSight sight = find_board(image, kSmallBoard);
  REQUIRE(sight.found());
  CHECK(largest_center_error_px(sight, X_CG) < kCenterTolerance_px);
}

TEST_CASE(
    "Of a grid that is partly covered the dots that are seen are found, where that is asked for") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.3, 1.0, 0.1);
  const cv::Mat whole =
      test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG);
  const BoardSight all = find_board(whole, kSmallBoard);
  const auto covered = [&](std::size_t from, std::size_t to) {
    cv::Mat image = whole.clone();
    Eigen::Vector2d least = all.pixels[from], most = least;
    for (std::size_t i = from; i <= to; ++i) {
      least = least.cwiseMin(all.pixels[i]);
      most = most.cwiseMax(all.pixels[i]);
    }
    const cv::Point corner(cvRound(least.x()) - 20, cvRound(least.y()) - 20);
    cv::rectangle(image, corner, {cvRound(most.x()) + 20, cvRound(most.y()) + 20}, 120, cv::FILLED);
    return image;
  };
  const BoardSight some = find_board(covered(15, 17), kSmallBoard, BoardPart::kMost);
  INFO(some.reason);
  REQUIRE(some.pixels.size() >= 28);  // 3 are covered, and the rims of two more
  REQUIRE(some.seen.size() == some.pixels.size());
  const auto points = seen_points(kSmallBoard, some);
  for (std::size_t i = 0; i < some.seen.size(); ++i) {
    CHECK((some.seen[i] < 15 || some.seen[i] > 17));
    CHECK((some.pixels[i] - all.pixels[some.seen[i]]).norm() < kCenterTolerance_px);
    CHECK(points[i] == board_points(kSmallBoard)[some.seen[i]]);
  }
  CHECK_FALSE(find_board(covered(15, 17), kSmallBoard).found());
  CHECK_FALSE(find_board(covered(0, 6), kSmallBoard, BoardPart::kMost).found());  // a whole row
  CHECK_FALSE(find_board(covered(9, 28), kSmallBoard, BoardPart::kMost).found());
}

TEST_CASE("A board whose dark rim has its middle in a dot is found") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.0, 0.0, 0.05);
  cv::Mat image = test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG);
  const Eigen::Vector2d middle = find_board(image, kSmallBoard).pixels[17];
  cv::rectangle(image, cv::Point(cvRound(middle.x()) - 225, cvRound(middle.y()) - 195),
                cv::Point(cvRound(middle.x()) + 225, cvRound(middle.y()) + 195), 60, 12);
  CHECK(find_board(image, kSmallBoard).found());
}

/// A picture of an asymmetric grid, and where its dots are.
struct DrawnRows {
  DrawnRows(const Board& board, double turn) {
    const Pose X_CG = test::board_before_camera(board, 0.45, 0.3, 1.0, turn);
    for (const Eigen::Vector2d& p : board_points(board)) {
      centers.push_back(
          project(test::small_camera(), X_CG * Eigen::Vector3d(p.x(), p.y(), 0.0)).value());
      cv::circle(image,
                 cv::Point(cvRound(16.0 * centers.back().x()), cvRound(16.0 * centers.back().y())),
                 16 * 9, 40, cv::FILLED, cv::LINE_AA, 4);
    }
  }

  cv::Mat image{480, 640, CV_8UC1, cv::Scalar(210)};
  std::vector<Eigen::Vector2d> centers;
};

TEST_CASE("An asymmetric grid is found in OpenCV's order, however it is turned") {
  const Board board = parse_board("acircles:4x7:20mm");
  REQUIRE(board_points(board)[5] == Eigen::Vector2d(0.06, 0.02));
  for (const double turn : {0.0, 1.0, 3.0, 4.5}) {
    const auto [image, centers] = DrawnRows(board, turn);
    const BoardSight sight = find_board(image, board);
    INFO(sight.reason);
    REQUIRE(sight.pixels.size() == centers.size());
    for (std::size_t i = 0; i < centers.size(); ++i)
      CHECK((sight.pixels[i] - centers[i]).norm() < kDrawnCenterTolerance_px);
  }
}

TEST_CASE(
    "A board of shifted rows whose counts are exchanged is told as such, another one is not") {
  const cv::Mat image = DrawnRows(parse_board("acircles:4x7:20mm"), 1.0).image;
  CHECK_THAT(find_board(image, parse_board("acircles:7x4:20mm")).reason,
             Catch::Contains("(28 dots in the largest lattice: are the counts"));
  CHECK_THAT(find_board(image, parse_board("acircles:7x5:20mm")).reason,
             Catch::Contains("(28 dots in the largest lattice)"));
}

TEST_CASE("A grid is never taken mirrored and its x axis points most to the right") {
  const Board square{Board::Kind::kCircles, 5, 5, 0.03};
  for (const double turn : {0.0, 1.0, 2.5, 4.0}) {
    const Pose X_CG = test::board_before_camera(square, 0.35, 0.2, 0.3, turn);
    const BoardSight sight =
        find_board(test::picture_of_dots(test::small_camera(), square, 0.016, X_CG), square);
    REQUIRE(sight.found());
    const Eigen::Vector2d x = sight.pixels[4] - sight.pixels[0];
    const Eigen::Vector2d y = sight.pixels[20] - sight.pixels[0];
    CHECK(x.x() * y.y() - x.y() * y.x() > 0.0);
    CHECK(x.normalized().x() > 0.6);
  }
}

TEST_CASE("Clutter beside the grid does not disturb it") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.4, 0.4, 0.5, 0.2);
  cv::Mat image = test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG);
  cv::rectangle(image, {0, 0, 60, 480}, 60, cv::FILLED);
  for (int i = 0; i < 12; ++i) {
    cv::circle(image, {80 + 45 * i, 20 + 7 * (i % 3)}, 5 + 2 * (i % 4), 50, cv::FILLED);
    cv::putText(image, std::to_string(i), {70 + 48 * i, 470}, cv::FONT_HERSHEY_PLAIN, 1.5, 20, 2);
  }
  const BoardSight sight = find_board(image, kSmallBoard);
  REQUIRE(sight.found());
  CHECK(largest_center_error_px(sight, X_CG) < kCenterTolerance_px);
}

TEST_CASE(
    "A grid with a missing dot, one too large and an empty image are not found, with a reason") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.3, 1.0, 0.1);
  const auto camera = test::small_camera();
  const BoardSight missing = find_board(
      test::picture_of_dots(camera, kSmallBoard, kDotDiameter, X_CG, {}, 9), kSmallBoard);
  CHECK_FALSE(missing.found());
  CHECK_THAT(missing.reason, Catch::Contains("7 x 5") && Catch::Contains("34 dots"));
  const cv::Mat whole = test::picture_of_dots(camera, kSmallBoard, kDotDiameter, X_CG);
  CHECK_FALSE(find_board(whole, {Board::Kind::kCircles, 6, 5, 0.03}).found());
  CHECK_FALSE(find_board(cv::Mat(480, 640, CV_8UC1, cv::Scalar(128)), kSmallBoard).found());
}

TEST_CASE("Large dots of a large image are measured in its full resolution") {
  const Board board{Board::Kind::kCircles, 11, 11, 0.04};
  cv::Mat image(5120, 5120, CV_8UC1, cv::Scalar(190));
  const auto center = [](int column, int row) {
    return Eigen::Vector2d(500.3 + 398.7 * column + 21.2 * row,
                           620.6 - 20.4 * column + 381.9 * row);
  };
  constexpr int kFractionBits = 6;
  const auto fixed_point = [](double x) {
    return static_cast<int>(std::lround(x * (1 << kFractionBits)));
  };
  for (int row = 0; row < 11; ++row) {
    for (int column = 0; column < 11; ++column) {
      const Eigen::Vector2d c = center(column, row);
      cv::circle(image, {fixed_point(c.x()), fixed_point(c.y())}, fixed_point(40.0), 30, cv::FILLED,
                 cv::LINE_AA, kFractionBits);
    }
  }
  const BoardSight sight = find_board(image, board);
  REQUIRE(sight.found());
  double largest = 0.0;
  for (int i = 0; i < 121; ++i) {
    largest = std::max(largest, (sight.pixels[i] - center(i % 11, i / 11)).norm());
  }
  CHECK(largest < kDrawnCenterTolerance_px);
}

TEST_CASE("A chessboard's inner corners are found, not mirrored") {
  const Board board{Board::Kind::kChessboard, 6, 4, 0.03};
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(220));
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 7; ++column) {
      const cv::Rect square(100 + 50 * column, 90 + 50 * row, 50, 50);
      if ((row + column) % 2 == 0) cv::rectangle(image, square, 30, cv::FILLED);
    }
  }
  CHECK_THAT(find_board(image, {Board::Kind::kChessboard, 7, 4, 0.03}).reason,
             Catch::Contains("6 x 4 inner corners is seen"));
  const BoardSight sight = find_board(image, board);
  REQUIRE(sight.found());
  const Eigen::Vector2d x = sight.pixels[5] - sight.pixels[0];
  const Eigen::Vector2d y = sight.pixels[18] - sight.pixels[0];
  CHECK(x.x() * y.y() - x.y() * y.x() == Approx(250.0 * 150.0).epsilon(0.01));
}

TEST_CASE("The stated deviation of a dot's centre is that of its scatter under noise") {
  const Pose X_CG = test::board_before_camera(kSmallBoard, 0.35, 0.3, 1.0, 0.1);
  cv::Mat still = test::picture_of_dots(test::small_camera(), kSmallBoard, kDotDiameter, X_CG);
  cv::GaussianBlur(still, still, {}, 1.0);
  constexpr int kPictures = 30;
  constexpr double kNoise = 4.0;  // grey levels
  cv::RNG random(1);
  std::vector<BoardSight> sights;
  for (int i = 0; i < kPictures; ++i) {
    cv::Mat noise(still.size(), CV_16S), noisy;
    random.fill(noise, cv::RNG::NORMAL, 0.0, kNoise);
    cv::add(still, noise, noisy, cv::noArray(), CV_8U);
    sights.push_back(find_board(noisy, kSmallBoard));
    REQUIRE(sights.back().found());
  }
  double scatter = 0.0, stated = 0.0;
  for (std::size_t dot = 0; dot < sights[0].pixels.size(); ++dot) {
    Eigen::Vector2d middle(0.0, 0.0);
    for (const BoardSight& sight : sights) middle += sight.pixels[dot] / kPictures;
    for (const BoardSight& sight : sights) {
      scatter += (sight.pixels[dot] - middle).squaredNorm() / (2.0 * (kPictures - 1.0));
      stated += sight.dot_sigmas_px[dot] * sight.dot_sigmas_px[dot] / kPictures;
    }
  }
  CHECK(std::sqrt(stated / scatter) > 0.8);
  CHECK(std::sqrt(stated / scatter) < 1.25);
}

TEST_CASE("A board of unknown pitch has a shape, and no lengths are taken from it") {
  const Board board = parse_board("circles:6x5:?", BoardUse::kShape);
  CHECK(board.columns == 6);
  CHECK_FALSE(board.pitch_known);
  CHECK(board.pitch == 0.001);
  CHECK(parse_board("circles:6x5:34.5mm", BoardUse::kShape).pitch_known);
  CHECK_THROWS_MATCHES(parse_board("circles:6x5:?"), InputError,
                       Refused(Cause::kMissing, "'circles:6x5:?'"));
  CHECK_THROWS_AS(parse_board("circles:6x5:?mm", BoardUse::kShape), InputError);
}

TEST_CASE("A board is described by kind, counts and pitch, and nothing else") {
  const Board board = parse_board("circles:6x5:34.5mm");
  CHECK(board.kind == Board::Kind::kCircles);
  CHECK(board.columns == 6);
  CHECK(board.rows == 5);
  CHECK(board.pitch == Approx(0.0345));
  CHECK(parse_board("chessboard:9x6:25mm").kind == Board::Kind::kChessboard);
  for (const char* wrong : {"", "circles:6x6", "dots:6x6:34mm", "circles:6x6:-1mm",
                            "circles:2x6:3mm", "circles:6x6:0mm", "circles:6x6:nanmm"}) {
    CHECK_THROWS_AS(parse_board(wrong), InputError);
  }
}

void check_all_found(const std::filesystem::path& folder, const std::string& extension,
                     const Board& board, int images_expected) {
  int images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != extension) continue;
    ++images;
    const BoardSight sight = find_board(cv::imread(entry.path(), cv::IMREAD_GRAYSCALE), board);
    INFO(entry.path() << ": " << sight.reason);
    CHECK(sight.pixels.size() == static_cast<std::size_t>(board.columns * board.rows));
  }
  CHECK(images == images_expected);
}

const Board kSix{Board::Kind::kCircles, 6, 6, 0.034};

TEST_CASE("All dots of the photographs from ViSP's tutorial are found") {
  const auto folder = test::shared_data("circle_grids/visp");
  if (!folder) return;
  check_all_found(*folder, ".jpg", kSix, 5);
}

TEST_CASE("All dots of the photographs from ViSP's images are found") {
  const auto folder = test::visp_image("calibration");
  if (!folder) return;
  check_all_found(*folder, ".pgm", kSix, 4);
}

TEST_CASE("All dots of the photographs from robot_cal_tools are found") {
  const auto folder = test::shared_data("circle_grids/rct");
  if (!folder) return;
  check_all_found(*folder, ".png", {Board::Kind::kCircles, 10, 10, 0.0254}, 10);
}

}  // namespace
}  // namespace planar
