#include <cairo.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <regex>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/offline/paper/drawings.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;

constexpr double kPixelsPerMm = 10.0;

/// The page as a printer of 254 dpi would print it, white 255.
cv::Mat printed(const Page& page) {
  const cv::Size size(static_cast<int>(kPixelsPerMm * page.size_mm.x()),
                      static_cast<int>(kPixelsPerMm * page.size_mm.y()));
  cv::Mat ink(size, CV_8UC1, cv::Scalar(0));
  cv::Mat rows(size.height, cairo_format_stride_for_width(CAIRO_FORMAT_A8, size.width), CV_8UC1,
               cv::Scalar(0));
  cairo_surface_t* surface = cairo_image_surface_create_for_data(
      rows.data, CAIRO_FORMAT_A8, size.width, size.height, rows.cols);
  cairo_t* cairo = cairo_create(surface);
  cairo_scale(cairo, kPixelsPerMm, kPixelsPerMm);
  Pen pen(cairo);
  page.draw(pen);
  cairo_surface_flush(surface);
  ink = 255 - rows.colRange(0, size.width);
  cairo_destroy(cairo);
  cairo_surface_destroy(surface);
  return ink;
}

/// Where a place on the page lies in what is printed; pixel centres are at whole numbers.
Eigen::Vector2d pixel_of(const Eigen::Vector2d& place_mm) {
  return kPixelsPerMm * place_mm - Eigen::Vector2d(0.5, 0.5);
}

TEST_CASE("A printed board is found, each point where it was drawn") {
  // A tenth of a per cent of the pitch, and the board's size that this makes.
  const double tolerance_pitches = 1e-3;
  for (const std::string words :
       {"circles:11x11:15mm", "circles:7x9:20.5mm", "chessboard:9x7:18mm"})
    for (const std::string page : {"", "A4", "400x350mm"}) {
      INFO(words << " on '" << page << "'");
      const BoardPage drawn = board_page(words, page);
      const BoardSight sight = find_board(printed(drawn.page), drawn.board);
      REQUIRE(sight.found());
      const auto points = board_points(drawn.board);
      const double pitch_px = kPixelsPerMm * 1e3 * drawn.board.pitch;
      const auto last = points.size() - 1;
      const double span = (points[last] - points[0]).norm() / drawn.board.pitch;
      CHECK((sight.pixels[last] - sight.pixels[0]).norm() / (span * pitch_px) ==
            Approx(1.0).margin(tolerance_pitches));
      double farthest_px = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2d drawn_px = pixel_of(drawn.first_point_mm + 1e3 * points[i]);
        // A chessboard may be found from its other end.
        const double apart_px = std::min((sight.pixels[i] - drawn_px).norm(),
                                         (sight.pixels[last - i] - drawn_px).norm());
        farthest_px = std::max(farthest_px, apart_px);
      }
      CHECK(farthest_px < tolerance_pitches * pitch_px);
    }
}

TEST_CASE("Dots are as large as those of virtual boards, and a ruler says the scale") {
  const BoardPage drawn = board_page("circles:5x4:50mm", "");
  CHECK(drawn.mark_mm == Approx(20.0));
  const BoardSight sight = find_board(printed(drawn.page), drawn.board);
  REQUIRE(sight.found());
  CHECK(std::sqrt(sight.dot_areas_px2[0] * 4.0 / M_PI) ==
        Approx(kPixelsPerMm * 20.0).epsilon(0.002));
  CHECK(drawn.rulers_mm == Eigen::Vector2d(100.0, 100.0));
  CHECK(board_page("circles:3x3:5mm", "").rulers_mm == Eigen::Vector2d(80.0, 20.0));
  CHECK(board_page_list(drawn).text() ==
        "page                299 x 255 mm\n"
        "board               5 x 4 dots, 50 mm apart\n"
        "dots                20 mm wide\n"
        "rulers              100 and 100 mm\n");
}

TEST_CASE("SVG and PDF have the page's size, and say that they are ours") {
  const Page page = board_page("circles:11x11:15mm", "A4").page;
  const std::string svg = page_text(page, PageFormat::kSvg);
  CHECK_THAT(svg, Contains(R"(width="210mm" height="297mm" viewBox="0 0 210 297")"));
  CHECK(kind_of_text(svg) == kPaperKind);
  const std::string pdf = page_text(page, PageFormat::kPdf);
  std::smatch box;
  REQUIRE(std::regex_search(pdf, box, std::regex(R"(MediaBox \[ 0 0 (\S+) (\S+) \])")));
  CHECK(std::stod(box[1]) == Approx(210.0 / 25.4 * 72.0).epsilon(1e-6));
  CHECK(std::stod(box[2]) == Approx(297.0 / 25.4 * 72.0).epsilon(1e-6));
  CHECK(kind_of_text(pdf) == kPaperKind);
  CHECK(page_format("a.svg") == PageFormat::kSvg);
  CHECK_THROWS_MATCHES(page_format("a.png"), InputError, Refused(Cause::kInvalid, "a.png"));
}

TEST_CASE("A page lies as the board does") {
  CHECK(board_page("circles:11x7:15mm", "A4").page.size_mm == Eigen::Vector2d(297.0, 210.0));
  CHECK(board_page("circles:7x11:15mm", "A3").page.size_mm == Eigen::Vector2d(297.0, 420.0));
}

TEST_CASE("A board that does not fit is refused with the pitch and the count that do") {
  const auto refuses = [](const char* board, const char* page, const char* name,
                          Cause cause = Cause::kInvalid) {
    CHECK_THROWS_MATCHES(board_page(board, page), InputError, Refused(cause, name));
  };
  for (const char* name : {"599 x 601 mm", "--page is 210 x 297 mm", "16.1 mm", "3 x 4"})
    refuses("circles:11x11:50mm", "A4", name);
  CHECK_NOTHROW(board_page("circles:11x11:16.1mm", "A4"));
  CHECK_THROWS_AS(board_page("circles:11x11:16.2mm", "A4"), InputError);
  CHECK_NOTHROW(board_page("circles:3x4:50mm", "A4"));
  CHECK_THROWS_AS(board_page("circles:4x4:50mm", "A4"), InputError);
  refuses("circles:6x6:?", "", "circles:6x6:?", Cause::kMissing);
  refuses("circles:6x6:20mm", "A5", "--page is 'A5'");
  refuses("circles:6x6:20mm", "0x10mm", "50 to 5000 mm");
}

/// Returns how far from this place the page has ink first, along a direction that has no line.
double rim_mm(const cv::Mat& image, const Eigen::Vector2d& place_mm) {
  const Eigen::Vector2d along = Eigen::Vector2d(2.0, 1.0).normalized();
  for (double r = 0.5; r < 30.0; r += 0.02) {
    const Eigen::Vector2d at = pixel_of(place_mm + r * along);
    if (image.at<std::uint8_t>(static_cast<int>(std::lround(at.y())),
                               static_cast<int>(std::lround(at.x()))) < 128)
      return r;
  }
  return 0.0;
}

TEST_CASE("Lamps and reflector are drawn at their places in the tool's frame") {
  ToolMount mount;
  mount.lamps = {0.040, {0.008, 0.010}};
  mount.p_TS = {10.0e-3, -25.0e-3};
  const ToolPage drawn = tool_page(mount, "");
  const cv::Mat image = printed(drawn.page);
  constexpr double kLine_mm = 0.2;
  CHECK(rim_mm(image, drawn.end_point_mm + Eigen::Vector2d(-20.0, 0.0)) ==
        Approx(4.0).margin(kLine_mm));
  CHECK(rim_mm(image, drawn.end_point_mm + Eigen::Vector2d(20.0, 0.0)) ==
        Approx(5.0).margin(kLine_mm));
  CHECK(rim_mm(image, drawn.end_point_mm + Eigen::Vector2d(10.0, 25.0)) ==
        Approx(19.05).margin(kLine_mm));
}

TEST_CASE("Parts of a tool that overlap are refused") {
  ToolMount mount;
  mount.lamps = {0.040, {0.008, 0.008}};
  mount.p_TS = {0.014, -0.008};
  for (const char* name : {"lamp 2 and reflector", "10.0 mm", "23.1 mm"})
    CHECK_THROWS_MATCHES(tool_page(mount, ""), InputError, Refused(Cause::kContradiction, name));
  CHECK_THROWS_MATCHES(tool_page(ToolMount{{0.040, {0.008, 0.008}}}, "50x50mm"), InputError,
                       Refused(Cause::kInvalid, "--page is 50 x 50 mm"));
}

}  // namespace
}  // namespace planar
