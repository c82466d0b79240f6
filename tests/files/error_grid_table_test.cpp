#include "planar_servo/files/tables/grid_exports.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <opencv2/core.hpp>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/pair_table.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

const std::vector<std::string> kRemarks{"# error = seen - true", "# made from: it's \"map\".yaml"};

/// Three columns and two rows, 10 mm apart, with an error that grows with x and y; the last node is
/// not valid.
ErrorGrid small_grid() {
  ErrorGrid grid;
  grid.origin = {-0.01, 0.02};
  grid.step = 0.01;
  grid.columns = 3;
  grid.rows = 2;
  grid.errors.resize(2, 6);
  grid.sigmas.resize(6);
  grid.inside.resize(6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    grid.errors.col(i) = 1e-3 * grid.node(i);
    grid.sigmas[i] = 1e-6 * static_cast<double>(i + 1);
    grid.inside[i] = i < 5;
  }
  return grid;
}

template <typename Number>
Number number_at(const std::string& bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof(Number));
  return number;
}

TEST_CASE("A grid's table is read as pairs of its valid nodes") {
  const test::TemporaryFolder folder;
  const std::vector<PairRow> pairs =
      read_pairs(folder.write("grid.csv", error_grid_text(small_grid(), kRemarks)));
  REQUIRE(pairs.size() == 5);
  CHECK(pairs[4].id == "0,30");
  CHECK((pairs[4].p_vision - Eigen::Vector2d(0.0, 0.03)).norm() < test::kWrittenNanometre);
  CHECK((pairs[4].error() - Eigen::Vector2d(0.0, 30e-6)).norm() < test::kWrittenNanometre);
  CHECK(pairs[4].sigma_tracker.value() == Approx(5e-6));
  CHECK_FALSE(pairs[4].lamps_B);
}

TEST_CASE("A grid of another program needs only places and errors") {
  const test::TemporaryFolder folder;
  const std::vector<PairRow> pairs =
      read_pairs(folder.write("grid.csv", "dy_mm, y_mm, dx_mm, x_mm\n0.2,20,-0.1,10\n"));
  REQUIRE(pairs.size() == 1);
  CHECK((pairs[0].p_vision - Eigen::Vector2d(0.010, 0.020)).norm() < test::kWrittenNanometre);
  CHECK((pairs[0].error() - Eigen::Vector2d(-1e-4, 2e-4)).norm() < test::kWrittenNanometre);
  CHECK_FALSE(pairs[0].sigma_tracker);
}

TEST_CASE("A bad grid is refused by its line") {
  const test::TemporaryFolder folder;
  const std::string head = "x_mm,y_mm,dx_mm,dy_mm,sigma_mm,valid\n";
  const auto bad = folder.write("bad.csv", head + "0,0,nan,0,,1\n0,0,0,0,-1,1\n0,0,0,0,,yes\n");
  for (const char* place : {"bad.csv:2: dx_mm", "bad.csv:3: sigma_mm", "bad.csv:4: valid"})
    CHECK_THROWS_MATCHES(read_pairs(bad), InputError, Refused(Cause::kInvalid, place));
  CHECK_THROWS_MATCHES(read_pairs(folder.write("grid.csv", head + "0,0,0,0,,0\n")), InputError,
                       Refused(Cause::kInsufficient, "grid.csv"));
  CHECK_THROWS_MATCHES(read_pairs(folder.write("grid.csv", head)), InputError,
                       Refused(Cause::kMissing, "grid.csv"));
  CHECK_THROWS_MATCHES(read_pairs(folder.write("grid.csv", "x_mm,y_mm,dx_mm\n0,0,0\n")), InputError,
                       Refused(Cause::kMissing, "dy_mm"));
}

TEST_CASE("NumPy's format has its header before aligned rows of 41 bytes") {
  const std::string text = grid_text(GridFormat::kNumpy, small_grid(), kRemarks);
  CHECK(text.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t data = 10 + number_at<std::uint16_t>(text, 8);
  CHECK(data % 64 == 0);
  CHECK(text[data - 1] == '\n');
  CHECK_THAT(text.substr(10, data - 10), Contains("'shape': (2, 3)") &&
                                             Contains("(('format: planar-servo/error_grid/1") &&
                                             Contains("it_s _map_.yaml', 'x_mm'), '<f8')"));
  constexpr std::size_t kRow = 41;
  REQUIRE(text.size() == data + 6 * kRow);
  const std::size_t fifth = data + 4 * kRow;
  CHECK(number_at<double>(text, fifth) == Approx(0.0).margin(1e-12));
  CHECK(number_at<double>(text, fifth + 8) == Approx(30.0));
  CHECK(number_at<double>(text, fifth + 24) == Approx(0.030));
  CHECK(number_at<double>(text, fifth + 32) == Approx(0.005));
  CHECK(text[fifth + 40] == 1);
  CHECK(text.back() == 0);
}

TEST_CASE("OpenCV's file holds the pixel that is seen at each true one, deviations and validity") {
  const std::string text = grid_text(GridFormat::kOpencvRemap, small_grid(), kRemarks);
  const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  cv::Mat map, sigma, valid;
  file["map"] >> map;
  file["sigma_mm"] >> sigma;
  file["valid"] >> valid;
  CHECK(static_cast<double>(file["x0_mm"]) == Approx(-10.0));
  CHECK(static_cast<double>(file["step_mm"]) == Approx(10.0));
  REQUIRE(map.type() == CV_32FC2);
  const auto seen = map.at<cv::Vec2f>(1, 2);
  CHECK(seen[0] == Approx(2.0 + 0.010 / 10.0));
  CHECK(seen[1] == Approx(1.0 + 0.030 / 10.0));
  CHECK(sigma.at<float>(1, 2) == Approx(0.006f));
  CHECK(cv::countNonZero(valid) == 5);
}

TEST_CASE("Each format is recognised as ours, however long its file, and others are not") {
  const test::TemporaryFolder folder;
  ErrorGrid large = small_grid();
  large.columns = 300;
  large.rows = 20;
  large.errors = Eigen::Matrix2Xd::Zero(2, large.nodes());
  large.sigmas = Eigen::VectorXd::Zero(large.nodes());
  large.inside.setConstant(large.nodes(), true);
  for (const GridFormat format : values_of(kGridFormats)) {
    for (const ErrorGrid& grid : {small_grid(), large}) {
      const std::string text = grid_text(format, grid, kRemarks);
      CHECK(kind_of_text(text) == kErrorGridKind);
      CHECK_NOTHROW(require_writable(folder.write("file", text), kErrorGridKind));
    }
  }
  const std::string theirs =
      std::string("\x93NUMPY\x01\x00v\x00", 10) + "{'descr': '<f8'}\n12345678";
  for (const std::string& text : {theirs, std::string("2,2\n1,1\n0,0\n")})
    CHECK_THROWS_MATCHES(require_writable(folder.write("file", text), kErrorGridKind), InputError,
                         Refused(Cause::kExists, "/file"));
}

}  // namespace
}  // namespace planar
