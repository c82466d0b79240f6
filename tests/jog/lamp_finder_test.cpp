#include "planar_servo/work/jog/lamp_finder.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/files/calibrated_cell.h"
#include "support/jog_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using test::JogBench;

/// The camera of a cell behind a lens that a person turns.
class TurnedLens final : public FrameSource {
 public:
  double blur_px{0.0};
  bool over_plate{false};  ///< grey beyond the dark round the lamps
  cv::Rect region_px;      ///< of the frame taken last

  explicit TurnedLens(FrameSource& camera) : camera_(camera) {}
  cv::Size sensor_size_px() const override { return camera_.sensor_size_px(); }
  void set_region(const cv::Rect& region) override { camera_.set_region(region); }
  FrameResult next_frame() override {
    FrameResult result = camera_.next_frame();
    region_px = result.frame.region_px;
    if (over_plate) {
      cv::Mat near_lamps;
      cv::dilate(result.frame.image > 60, near_lamps, cv::Mat::ones(13, 13, CV_8U));
      result.frame.image = result.frame.image.clone();
      result.frame.image.setTo(80, ~near_lamps);
    }
    if (blur_px > 0.0) {
      cv::Mat blurred;
      cv::GaussianBlur(result.frame.image, blurred, {}, blur_px);
      result.frame.image = blurred;
    }
    return result;
  }
  std::optional<std::string> fault() const override { return camera_.fault(); }
  FrameCounts counts() const override { return camera_.counts(); }
  CameraExposure exposure() const override { return camera_.exposure(); }
  void set_exposure(const CameraExposure& exposure) override { camera_.set_exposure(exposure); }

 private:
  FrameSource& camera_;
};

/// A cell whose camera has such a lens.
class LensCell final : public CellDevices {
 public:
  TurnedLens lens;

  explicit LensCell(CellDevices& cell) : lens(cell.camera()), cell_(cell) {}
  Clock& clock() override { return cell_.clock(); }
  FrameSource& camera() override { return lens; }
  DriveGroup& drives() override { return cell_.drives(); }
  Tracker& tracker() override { return cell_.tracker(); }
  BoardPresenter* board_presenter() override { return nullptr; }
  std::shared_ptr<Judge> truth() override { return nullptr; }

 private:
  CellDevices& cell_;
};

struct FocusFigures {
  double mean{0.0}, first{0.0}, second{0.0}, best{0.0};
};

FocusFigures figures_of(const std::string& text) {
  FocusFigures figures;
  INFO(text);
  REQUIRE(std::sscanf(text.c_str(), "edges %lf px wide (%lf, %lf), best %lf;", &figures.mean,
                      &figures.first, &figures.second, &figures.best) == 4);
  return figures;
}

/// The paper's cell, its arm bent, and a lens in front of its camera.
struct LensBench : JogBench {
  TurnedLens lens;
  LampFinder finder;

  LensBench()
      : lens(devices->camera()),
        finder({lens.sensor_size_px(), cell.lamps.layout, {}}, cell.lamps.method, lens,
               cell.camera.follow_region_px) {
    bend();
  }
};

TEST_CASE("The edges' width grows on however far a lens is out of focus, and the best is kept") {
  LensBench bench;
  const FocusFigures sharp = figures_of(bench.finder.focus());
  CHECK(sharp.best == sharp.mean);
  double narrower = sharp.mean;
  for (const double blur_px : {1.0, 2.0, 4.0, 8.0, 12.0}) {
    bench.lens.blur_px = blur_px;
    const FocusFigures blurred = figures_of(bench.finder.focus());
    CHECK(blurred.mean > narrower);
    CHECK(blurred.best == sharp.mean);
    narrower = blurred.mean;
  }
  bench.finder.forget_best();
  CHECK(figures_of(bench.finder.focus()).best > sharp.mean);
}

TEST_CASE("An edge is as wide as its blur makes it from a fifth to four fifths of the contrast") {
  constexpr double kSigmas = 1.683;  // between these quantiles of a Gaussian
  constexpr double kSharp_px = 0.8;  // the virtual lens
  LensBench bench;
  bench.lens.blur_px = 2.0;
  CHECK(figures_of(bench.finder.focus()).mean ==
        Approx(kSigmas * std::hypot(kSharp_px, 2.0)).epsilon(0.15));
}

TEST_CASE("A grey plate beneath the lamps does not widen their edges") {
  LensBench bench;
  const FocusFigures bare = figures_of(bench.finder.focus());
  bench.lens.over_plate = true;
  CHECK(figures_of(bench.finder.focus()).mean == Approx(bare.mean).epsilon(0.1));
}

TEST_CASE("While a lens is turned only the region of the lamps is read, until they are lost") {
  LensBench bench;
  const cv::Rect whole({}, bench.lens.sensor_size_px());
  bench.finder.focus();
  CHECK(bench.lens.region_px == whole);
  bench.finder.focus();
  CHECK(bench.lens.region_px.width == bench.cell.camera.follow_region_px);
  for (int i = 0; i < 3; ++i) bench.done("joint 1 15");
  figures_of(bench.finder.focus());
  CHECK(bench.lens.region_px == whole);
}

TEST_CASE("Lamps are found in the whole frame, also of a cell that is not calibrated") {
  JogBench bench;
  bench.bend();
  bench.devices->camera().set_region({0, 0, 64, 64});
  const std::string found = bench.done("find");
  CHECK_THAT(found, Contains("lamps at (") && Contains("px wide"));
  CHECK_THAT(found, !Contains("on the plane"));
  bench.done("exposure 100");
  CHECK_THAT(bench.refused("find"), Contains("no two lamps in the whole frame: no_lamp"));
  CHECK_THAT(bench.refused("focus"), Contains("no two lamps in the whole frame"));
}

TEST_CASE("A calibrated cell says where on the plane the lamps are, and where its tool was seen") {
  JogBench bench(read_cell(test::workshop_cell_file()));
  bench.bend();
  CHECK_THAT(bench.done("find"), Contains("\non the plane at (") && Contains(", uncompensated"));
  CHECK_FALSE(bench.console.seen());
  bench.done("look");
  CHECK(bench.console.seen());
  bench.done("joint 1 1");
  CHECK_FALSE(bench.console.seen());
}

TEST_CASE("In lines the best width is that since the last other command") {
  JogBench bench;
  LensCell cell(*bench.devices);
  JogConsole console(read_calibrated_cell(bench.cell), cell, "");
  const auto focused = [&] { return figures_of(test::execute(console, "focus").text); };
  const FocusFigures sharp = focused();
  cell.lens.blur_px = 2.0;
  CHECK(focused().best == sharp.mean);
  REQUIRE(test::execute(console, "where").done);
  const FocusFigures anew = focused();
  CHECK(anew.best == anew.mean);
}

TEST_CASE("A whole frame is saved as PNG, and neither another file nor another format is touched") {
  JogBench bench;
  const std::string file = (bench.folder / "frame.png").string();
  CHECK_THAT(bench.done("save " + file), Contains("the whole frame of 5120 x 5120 px"));
  const cv::Mat frame = cv::imread(file, cv::IMREAD_UNCHANGED);
  CHECK(frame.size() == bench.devices->camera().sensor_size_px());
  CHECK(frame.type() == CV_8UC1);
  CHECK_THAT(bench.refused("save " + file), Contains("frame.png") && Contains("name another file"));
  CHECK_THAT(bench.refused("save frame.jpg"), Contains("end the name in .png"));
}

TEST_CASE("A lamp's levels tell what is around, what is lit, and what is cut at either end") {
  cv::Mat image(100, 100, CV_8UC1, cv::Scalar(12));
  cv::circle(image, {50, 50}, 16, 200, cv::FILLED);
  const LampLevels good = read_lamp_levels(image);
  CHECK(good.ambient == 12);
  CHECK(good.lit == 200);
  CHECK(good.dark_share == 0.0);
  CHECK(good.clipped_share == 0.0);
  CHECK(good.bars == "▇           ▆   ");
  image(cv::Rect(0, 0, 100, 25)) = 0;
  image(cv::Rect(35, 35, 30, 15)) = 255;
  const LampLevels cut = read_lamp_levels(image);
  CHECK(cut.dark_share == Approx(2500.0 / 9179.0).margin(0.02));
  CHECK(cut.clipped_share == Approx(0.5).margin(0.15));
  CHECK_THAT(cut.text(), Contains("ambient 12") && Contains("% of what is around"));
}

}  // namespace
}  // namespace planar
