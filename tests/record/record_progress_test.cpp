#include "planar_servo/work/record/record_progress.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/manual_clock.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

/// Four places with a reading, one of which is recorded already, one without, and two views of the
/// board.
struct ProgressBench {
  RecordRequest request{read_cell(test::paper_cell_file()), {}, "recording"};
  test::ManualClock clock;

  ProgressBench() {
    for (const char* id : {"t0", "t1", "t2", "t3"})
      request.plan.push_back({id, Purpose::kTrain, TipPose{{0.3, 0.1}, 0.0}});
    request.plan.push_back({"u0", Purpose::kPose, TipPose{{0.3, 0.2}, 0.0}});
    for (const char* id : {"g0", "g1"})
      request.plan.push_back({id, Purpose::kHeldBoard, std::monostate()});
  }
  RecordProgress progress(LivePicture* display = nullptr) {
    BegunRecording begun;
    begun.ids = {"t0"};
    return {request, joints_of_plan(request.cell, request.plan), begun, clock, display};
  }
  void record(RecordProgress& progress, std::size_t row, double seconds,
              PlaceMark mark = PlaceMark::kDone) {
    progress.begin(row);
    clock.sleep_for_s(seconds);
    progress.end(row, mark);
  }
};

TEST_CASE(
    "The time left is told from the pace of places of the same sort, the others are counted") {
  ProgressBench bench;
  RecordProgress progress = bench.progress();
  CHECK(progress.text() ==
        "1 of 7, 3 places with a reading and 1 place without a reading and 2 views of the board "
        "left");
  bench.record(progress, 1, 20.0);
  CHECK(progress.text() ==
        "2 of 7, about 40 s and 1 place without a reading and 2 views of the board left");
  bench.record(progress, 2, 40.0, PlaceMark::kLeftOut);
  CHECK(progress.text() ==
        "3 of 7, about 30 s and 1 place without a reading and 2 views of the board left");
  bench.record(progress, 4, 5.0);
  bench.record(progress, 5, 60.0);
  CHECK(progress.text() == "5 of 7, about 90 s left");
  bench.record(progress, 3, 30.0);
  bench.record(progress, 6, 30.0);
  CHECK(progress.text() == "7 of 7");
}

TEST_CASE("Where a display is, a map has what is done in green and what is left out in red") {
  const test::TemporaryFolder folder;
  ProgressBench bench;
  LivePicture picture(folder / "view.png");
  RecordProgress progress = bench.progress(&picture);
  const auto pixels_on_map = [&](const cv::Scalar& bgr) {
    progress.finish();
    cv::Mat found;
    cv::inRange(cv::imread(folder / "view.png")(cv::Rect(16, 48, 512, 512)), bgr, bgr, found);
    return cv::countNonZero(found);
  };
  const cv::Scalar green(90, 220, 60), red(80, 80, 255);
  CHECK(pixels_on_map(green) == 0);  // t0 is done, but t3 lies above it
  bench.record(progress, 3, 20.0);
  CHECK(pixels_on_map(green) == 49);
  CHECK(pixels_on_map(red) == 0);
  bench.record(progress, 4, 20.0, PlaceMark::kLeftOut);
  CHECK(pixels_on_map(red) == 49);
}

}  // namespace
}  // namespace planar
