#include "planar_servo/lamps/lamp_detector.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/rendered_lamp.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using test::RenderedLamp;

// A centroid of whole pixels above half the step is good to 0.03 px for a lamp of 40 px.
constexpr double kCoarse_px = 0.2;

/// Noise that repeats from row block to row block: 26 million fresh values take too long.
cv::Mat noisy_frame(const cv::Size& size, const std::vector<RenderedLamp>& lamps,
                    std::mt19937& random) {
  cv::Mat bank = test::expose(test::background({size.width, 64}), random);
  cv::Mat frame(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) bank.row(v % bank.rows).copyTo(frame.row(v));
  for (const RenderedLamp& lamp : lamps) {
    const int half = static_cast<int>(lamp.diameter_px) + 8;
    const cv::Rect place(static_cast<int>(lamp.center_px.x()) - half,
                         static_cast<int>(lamp.center_px.y()) - half, 2 * half, 2 * half);
    RenderedLamp local = lamp;
    local.center_px -= Eigen::Vector2d(place.x, place.y);
    cv::Mat scene = test::background(place.size());
    test::add_lamp(scene, local);
    const cv::Rect visible = place & cv::Rect({0, 0}, size);
    test::expose(scene, random)(visible - place.tl()).copyTo(frame(visible));
  }
  return frame;
}

bool any_near(const std::vector<Blob>& blobs, const Eigen::Vector2d& place, double distance) {
  for (const Blob& blob : blobs) {
    if ((blob.uv_px - place).norm() < distance) return true;
  }
  return false;
}

TEST_CASE("LampDetector finds both lamps of full frames, none missed, none invented") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(60.0, 5060.0), turn(-150.0, 150.0);
  LampDetector detector;
  for (int i = 0; i < 12; ++i) {
    const RenderedLamp a{{place(random), place(random)}};
    RenderedLamp b{{place(random), place(random)}};
    if ((b.center_px - a.center_px).norm() < 100.0) b.center_px = a.center_px.reverse();
    const std::vector<Blob> found = detector.detect(noisy_frame({5120, 5120}, {a, b}, random));
    REQUIRE(found.size() == 2);
    CHECK(any_near(found, a.center_px, kCoarse_px));
    CHECK(any_near(found, b.center_px, kCoarse_px));
  }
}

TEST_CASE("LampDetector finds lamps of 12 to 120 px, dim and bright, and tells their size") {
  std::mt19937 random(8);
  LampDetector detector;
  for (const double diameter : {12.0, 13.0, 20.0, 60.0, 120.0}) {
    for (const double amplitude : {40.0, 180.0, 400.0}) {
      for (const double shift : {0.0, 1.3, 2.6, 3.9, 5.2}) {
        const RenderedLamp lamp{{300.3, 251.7 + shift}, diameter, 1.0, 0.0, amplitude};
        const std::vector<Blob> found = detector.detect(noisy_frame({640, 512}, {lamp}, random));
        REQUIRE(found.size() == 1);
        CHECK((found[0].uv_px - lamp.center_px).norm() < kCoarse_px);
        CHECK(found[0].diameter_px() == Approx(diameter).margin(1.0));
        CHECK(found[0].axis_ratio() > 0.9);
        CHECK(found[0].fill() > 0.95);
        CHECK(found[0].background == Approx(12.0).margin(1.0));
      }
    }
  }
}

TEST_CASE("LampDetector tells a saturated lamp from one that is not") {
  std::mt19937 random(9);
  const RenderedLamp clipped{{150, 150}, 40.0, 1.0, 0.0, 400.0};
  const RenderedLamp clean{{350, 150}, 40.0, 1.0, 0.0, 180.0};
  const auto found = LampDetector().detect(noisy_frame({500, 300}, {clipped, clean}, random));
  REQUIRE(found.size() == 2);
  CHECK(found[0].uv_px.x() < 200.0);  // the brighter one first
  CHECK(found[0].saturated_share > 0.9);
  CHECK(found[1].saturated_share == 0.0);
}

TEST_CASE("LampDetector ignores hot pixels and streaks, reports a third light as one") {
  std::mt19937 random(10);
  const RenderedLamp a{{300, 300}}, b{{500, 340}}, third{{800, 600}, 30.0};
  cv::Mat frame = noisy_frame({1024, 768}, {a, b, third}, random);
  std::uniform_int_distribution<int> u(0, 1023), v(0, 767);
  for (int i = 0; i < 400; ++i) {
    const cv::Point hot{u(random), v(random)};
    const bool on_lamp = cv::norm(hot - cv::Point(300, 300)) < 40 ||
                         cv::norm(hot - cv::Point(500, 340)) < 40 ||
                         cv::norm(hot - cv::Point(800, 600)) < 40;
    if (!on_lamp) frame(cv::Rect(hot, cv::Size(2, 2)) & cv::Rect({0, 0}, frame.size())) = 255;
  }
  cv::line(frame, {20, 700}, {600, 640}, cv::Scalar(240), 3);
  cv::line(frame, {900, 20}, {905, 500}, cv::Scalar(240), 4);
  const std::vector<Blob> found = LampDetector().detect(frame);
  REQUIRE(found.size() == 3);
  for (const RenderedLamp& lamp : {a, b, third}) CHECK(any_near(found, lamp.center_px, kCoarse_px));
}

TEST_CASE("LampDetector finds lamps that touch other lights") {
  constexpr double kTouched_px = 2.0;  // the other light moves the coarse centre
  std::mt19937 random(14);
  const RenderedLamp lamp{{300.4, 250.2}};
  const cv::Mat clean = noisy_frame({640, 512}, {lamp}, random);
  SECTION("a bright streak across it") {
    for (const double turn : {0.0, 0.4, 0.9, 1.6, 2.4}) {
      cv::Mat frame = clean.clone();
      const cv::Point2d along(250.0 * std::cos(turn), 250.0 * std::sin(turn));
      cv::line(frame, cv::Point2d(310.0, 255.0) - along, cv::Point2d(310.0, 255.0) + along,
               cv::Scalar(240), 4, cv::LINE_AA);
      CHECK(any_near(LampDetector().detect(frame), lamp.center_px, kTouched_px));
    }
  }
  SECTION("a dimmer reflection on which it lies") {
    cv::Mat scene = test::background({640, 512});
    test::add_lamp(scene, {{330.0, 260.0}, 200.0, 0.2, 0.5, 50.0, 3.0});
    test::add_lamp(scene, lamp);
    CHECK(
        any_near(LampDetector().detect(test::expose(scene, random)), lamp.center_px, kTouched_px));
  }
  SECTION("specks all round its rim") {
    cv::Mat frame = clean.clone();
    for (int i = 0; i < 6; ++i) {
      const cv::Point speck(static_cast<int>(300.0 + 21.0 * std::cos(1.05 * i)),
                            static_cast<int>(250.0 + 21.0 * std::sin(1.05 * i)));
      cv::circle(frame, speck, 3, cv::Scalar(255), cv::FILLED);
    }
    CHECK(any_near(LampDetector().detect(frame), lamp.center_px, kTouched_px));
  }
}

TEST_CASE("LampDetector takes neither streaks nor reflections nor a bright bar for lamps") {
  std::mt19937 random(15);
  cv::Mat frame = noisy_frame({1024, 768}, {}, random);
  for (const double turn : {0.1, 0.6, 1.2, 1.9, 2.8}) {
    const cv::Point2d along(280.0 * std::cos(turn), 280.0 * std::sin(turn));
    cv::line(frame, cv::Point2d(400, 380) - along, cv::Point2d(400, 380) + along, cv::Scalar(200),
             5, cv::LINE_AA);
  }
  cv::ellipse(frame, {800, 200}, {120, 20}, 30.0, 0.0, 360.0, cv::Scalar(90), cv::FILLED);
  cv::rectangle(frame, {900, 20}, {1000, 740}, cv::Scalar(120), cv::FILLED);
  CHECK(LampDetector().detect(frame).empty());
}

TEST_CASE("LampDetector learns its threshold anew where the background changes") {
  std::mt19937 random(16);
  cv::Mat scene = test::background({1536, 1024});
  for (int v = 0; v < scene.rows; ++v) {
    for (int u = 0; u < scene.cols; ++u) {
      scene.at<float>(v, u) += static_cast<float>(60.0 * u / scene.cols + 20.0 * v / scene.rows);
    }
  }
  const RenderedLamp dark{{120.0, 150.0}, 30.0, 1.0, 0.0, 40.0};
  const RenderedLamp bright{{1400.0, 900.0}, 30.0, 1.0, 0.0, 40.0};
  test::add_lamp(scene, dark);
  test::add_lamp(scene, bright);
  const auto found = LampDetector().detect(test::expose(scene, random));
  CHECK(found.size() == 2);
  CHECK(any_near(found, dark.center_px, kCoarse_px));
  CHECK(any_near(found, bright.center_px, kCoarse_px));
}

TEST_CASE("LampDetector looks in a window only, and beyond it for a lamp that reaches into it") {
  std::mt19937 random(17);
  const RenderedLamp inside{{200, 200}}, reaching{{300, 200}}, outside{{500, 300}};
  const cv::Mat frame = noisy_frame({640, 512}, {inside, reaching, outside}, random);
  const auto found = LampDetector().detect(frame, {150, 150, 145, 100});
  REQUIRE(found.size() == 2);
  CHECK(any_near(found, inside.center_px, kCoarse_px));
  CHECK(any_near(found, reaching.center_px, kCoarse_px));
  CHECK(LampDetector().detect(frame, {630, 500, 200, 200}).empty());
}

TEST_CASE("LampDetector marks a lamp that the image's edge cuts") {
  std::mt19937 random(11);
  const auto found = LampDetector().detect(noisy_frame({400, 300}, {{{5.0, 150.0}}}, random));
  REQUIRE(found.size() == 1);
  CHECK(found[0].touches_border);
}

TEST_CASE("LampDetector finds nothing in images without lamps, however small") {
  std::mt19937 random(12);
  LampDetector detector;
  CHECK(detector.detect(cv::Mat()).empty());
  CHECK(detector.detect(cv::Mat(5, 5, CV_8UC1, cv::Scalar(200))).empty());
  CHECK(detector.detect(cv::Mat(1, 4000, CV_8UC1, cv::Scalar(200))).empty());
  for (const int level : {0, 90, 255}) {
    CHECK(detector.detect(cv::Mat(300, 300, CV_8UC1, cv::Scalar(level))).empty());
  }
  CHECK(detector.detect(noisy_frame({1000, 700}, {}, random)).empty());
  CHECK_THROWS_AS(detector.detect(cv::Mat(300, 300, CV_8UC3)), std::invalid_argument);
}

TEST_CASE("LampDetector gives the same answer for images of changing size") {
  std::mt19937 random(13);
  const cv::Mat large = noisy_frame({900, 700}, {{{300, 300}}, {{500, 340}}}, random);
  const cv::Mat small = noisy_frame({300, 200}, {{{100, 100}}}, random);
  LampDetector detector;
  for (int i = 0; i < 3; ++i) {
    CHECK(detector.detect(large).size() == 2);
    CHECK(detector.detect(small).size() == 1);
  }
}

TEST_CASE("LampDetector finds the five discs of a photograph full of other things") {
  const auto path = test::visp_image("mire-2/image.0001.pgm");
  if (!path) return;
  const auto found = LampDetector().detect(cv::imread(path->string(), cv::IMREAD_GRAYSCALE));
  constexpr double kByEye_px = 3.0;
  for (const Eigen::Vector2d& disc :
       {Eigen::Vector2d(86, 180), Eigen::Vector2d(216, 168), Eigen::Vector2d(93, 267),
        Eigen::Vector2d(243, 248), Eigen::Vector2d(159, 213)}) {
    CHECK(any_near(found, disc, kByEye_px));
  }
}

}  // namespace
}  // namespace planar
