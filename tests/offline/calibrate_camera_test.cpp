#include "planar_servo/offline/calibrate_camera.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "calibration/board_image.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "support/refused.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;

const Board kBoard{Board::Kind::kCircles, 7, 5, 0.03};

cv::Mat picture(int view) {
  const Pose X_CG = test::board_before_camera(kBoard, 0.35, 0.4, 1.1 * view, 0.1 * view);
  return test::picture_of_dots(test::small_camera(), kBoard, 0.018, X_CG);
}

}  // namespace

TEST_CASE("Pictures without the board or of another size are left out by name, not fatal") {
  const test::TemporaryFolder folder;
  cv::imwrite(folder / "good.png", picture(0));
  cv::imwrite(folder / "empty.png", cv::Mat(480, 640, CV_8UC1, cv::Scalar(200)));
  cv::imwrite(folder / "small.png", cv::Mat(240, 320, CV_8UC1, cv::Scalar(200)));
  const BoardViews views =
      find_board_views({folder / "good.png", folder / "empty.png", folder / "small.png"}, kBoard);
  CHECK(views.problem.views.size() == 1);
  REQUIRE(views.rejected.size() == 2);
  CHECK_THAT(views.rejected[0].id, Contains("empty.png"));
  CHECK_THAT(views.rejected[0].reason, Contains("no grid of 7 x 5 dots"));
  CHECK_THAT(views.rejected[1].reason, Contains("320 x 240"));
}

TEST_CASE("A recording stands for its frames of plan grid, regions in their place on the sensor") {
  const test::TemporaryFolder folder;
  const cv::Mat whole = picture(1);
  const cv::Rect region(70, 50, 500, 380);
  cv::imwrite(folder / "whole.png", whole);
  cv::imwrite(folder / "region.png", whole(region));
  FrameRow row;
  row.id = "a";
  row.plan = Purpose::kHeldBoard;
  row.image = "whole.png";
  row.region_px = {0, 0, 640, 480};
  std::string table = frames_header() + frame_line(row);
  row.image = "region.png";
  row.region_px = region;
  table += frame_line(row);
  row.plan = Purpose::kTrain;
  row.image = "absent.png";
  table += frame_line(row);
  folder.write("frames.csv", table);

  const BoardViews views = find_board_views({folder.path()}, kBoard);
  REQUIRE(views.problem.views.size() == 2);
  CHECK(views.problem.width_px == 640);
  CHECK(views.problem.height_px == 480);
  const auto& pixels = views.problem.views[0].pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    // The same grey values: only the rough centres, where the rays start, may differ a little.
    CHECK((pixels[i] - views.problem.views[1].pixels[i]).norm() < 0.02);
  }
}

TEST_CASE("Missing images and recordings without a grid are named") {
  const test::TemporaryFolder folder;
  for (const char* missing : {"a.png", "b.png"})
    CHECK_THROWS_MATCHES(find_board_views({folder / "a.png", folder / "b.png"}, kBoard), InputError,
                         Refused(Cause::kMissing, missing));
  FrameRow row;
  row.id = "1";
  row.plan = Purpose::kTrain;
  row.image = "x.png";
  folder.write("frames.csv", frames_header() + frame_line(row));
  CHECK_THROWS_MATCHES(find_board_views({folder.path()}, kBoard), InputError,
                       Refused(Cause::kMissing, "'grid'"));
}

TEST_CASE("Points of another program must make whole views, bad lines are named") {
  const test::TemporaryFolder folder;
  const Board board{Board::Kind::kChessboard, 3, 3, 0.01};
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += std::to_string(10 * i) + ".5, 20\n";
  const auto views =
      board_views_from_points(folder.write("p.txt", "# u v\n" + nine + "\n" + nine), board, {});
  CHECK(views.problem.views.size() == 2);
  CHECK(views.problem.width_px == 82);
  const auto refuses = [&](const std::string& points, const std::string& name) {
    CHECK_THROWS_MATCHES(board_views_from_points(folder.write("p.txt", points), board, {}),
                         InputError, Refused(Cause::kInvalid, name));
  };
  refuses(nine + "1 2\n", "10 points");
  refuses("1 2\n1 x\n1 2 3\n", "p.txt:2:");
  refuses("1 2\n1 x\n1 2 3\n", "p.txt:3:");
}

TEST_CASE("Points in another order are told from those of another grid") {
  const test::TemporaryFolder folder;
  const Board board{Board::Kind::kCircles, 9, 7, 0.03};
  const auto lines = [](const auto& number_of) {  // of the point in each column and row of a view
    std::vector<std::string> points(63);
    for (int row = 0; row < 7; ++row)
      for (int column = 0; column < 9; ++column) {
        const double depth = 1.0 + 0.02 * column + 0.01 * row;
        points[static_cast<std::size_t>(number_of(column, row))] =
            fmt::format("{} {}\n", (100.0 + 60.0 * column + 5.0 * row) / depth,
                        (80.0 - 4.0 * column + 55.0 * row) / depth);
      }
    return fmt::format("{}", fmt::join(points, ""));
  };
  const auto read = [&](const auto& number_of) {
    return board_views_from_points(folder.write("p.txt", lines(number_of)), board, {});
  };
  CHECK_NOTHROW(read([](int column, int row) { return 9 * row + column; }));
  CHECK_NOTHROW(read([](int column, int row) { return 9 * (6 - row) + 8 - column; }));
  CHECK_THROWS_MATCHES(read([](int column, int row) { return 7 * column + row; }), InputError,
                       Refused(Cause::kInvalid, "grid 7 x 9"));
  CHECK_THROWS_MATCHES(
      read([](int column, int row) { return 9 * row + (row % 2 == 0 ? column : 8 - column); }),
      InputError, Refused(Cause::kInvalid, "9 x 7 points"));
}

TEST_CASE("Points of large and small grids in order are read, under a fisheye lens, too") {
  const test::TemporaryFolder folder;
  for (const auto& [columns, rows] : {std::pair(4, 3), {7, 6}, {9, 8}, {14, 10}, {24, 17}}) {
    const Board board{Board::Kind::kCircles, columns, rows, 0.03};
    const double height = 0.5 * columns / std::tan(70.0 * kDegree);  // the edge is seen at 70 deg
    std::string in_order, by_columns;
    const auto point = [&, columns = columns, rows = rows](int column, int row) {
      const Eigen::Vector2d p(column - 0.5 * (columns - 1), row - 0.5 * (rows - 1));
      const Eigen::Vector2d seen = 300.0 * std::atan(p.norm() / height) * p.normalized();
      return fmt::format("{} {}\n", 640.0 + seen.x(), 480.0 + seen.y());
    };
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) in_order += point(column, row);
    for (int column = 0; column < columns; ++column)
      for (int row = 0; row < rows; ++row) by_columns += point(column, row);
    CHECK_NOTHROW(board_views_from_points(folder.write("p.txt", in_order), board, {}));
    CHECK_THROWS_MATCHES(board_views_from_points(folder.write("p.txt", by_columns), board, {}),
                         InputError,
                         Refused(Cause::kInvalid, fmt::format("grid {} x {}", rows, columns)));
  }
}

TEST_CASE("The published chessboard points give the published camera within its uncertainty") {
  const auto points = test::test_data("calib1_points.txt");
  const Board board{Board::Kind::kChessboard, 7, 5, 2.54e-3};
  BoardViews views = board_views_from_points(points, board, {640, 480});
  views.problem.model = "plumb_bob";
  const Intrinsics k = intrinsics(calibrate_camera(views.problem).camera);
  // Two published standard deviations.
  CHECK(k.fx == Approx(809.948).margin(2 * 9.5));
  CHECK(k.fy == Approx(806.560).margin(2 * 8.8));
  CHECK(k.cx == Approx(361.996).margin(2 * 8.5));
  CHECK(k.cy == Approx(214.395).margin(2 * 13.3));
}

}  // namespace planar
