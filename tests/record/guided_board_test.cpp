#include "planar_servo/work/record/board_source.h"

#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/manual_clock.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

constexpr int kSide_px = 800;

/// A white picture with a board of 5 x 4 dots about this pixel; without it when there is none.
cv::Mat picture_with_board(const std::optional<cv::Point>& middle) {
  cv::Mat image(kSide_px, kSide_px, CV_8UC1, cv::Scalar(200));
  for (int i = 0; middle && i < 20; ++i)
    cv::circle(image, *middle + cv::Point(40 * (i % 5) - 80, 40 * (i / 5) - 60), 12, 40, cv::FILLED,
               cv::LINE_AA);
  return image;
}

/// A camera before which somebody holds a board: where it is at a time, or nowhere.
class WatchedBoard final : public FrameSource {
 public:
  WatchedBoard(Clock& clock, std::function<std::optional<cv::Point>(double t_s)> middle)
      : clock_(clock), middle_(std::move(middle)) {}
  double period_s{0.1};
  std::function<bool(double t_s)> fails = [](double) { return false; };

  cv::Size sensor_size_px() const override { return {kSide_px, kSide_px}; }
  void set_region(const cv::Rect& region_px) override { region_px_ = region_px; }
  FrameResult next_frame() override {
    clock_.sleep_for_s(period_s);
    const double t_s = clock_.now_s();
    if (fails(t_s)) return {FrameStatus::kLost, {}};
    return {FrameStatus::kOk, {picture_with_board(middle_(t_s)), region_px_, t_s, 0}};
  }
  std::optional<std::string> fault() const override { return std::nullopt; }
  FrameCounts counts() const override { return {}; }
  CameraExposure exposure() const override { return {0.01, 0.0}; }
  void set_exposure(const CameraExposure& /*exposure*/) override {}

 private:
  Clock& clock_;
  std::function<std::optional<cv::Point>(double t_s)> middle_;
  cv::Rect region_px_;
};

/// The keys of a terminal, or of a script through a pipe.
class Keys {
 public:
  explicit Keys(bool at_terminal) {
    if (at_terminal)
      REQUIRE(openpty(&ends_[1], &ends_[0], nullptr, nullptr, nullptr) == 0);
    else
      REQUIRE(pipe(ends_.data()) == 0);
  }
  ~Keys() {
    for (const int end : ends_) close(end);
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;
  int input() const { return ends_[0]; }
  void press_enter() const { REQUIRE(write(ends_[1], "\n", 1) == 1); }
  /// Returns whether an Enter is still there to be read.
  bool is_left() const {
    pollfd input{ends_[0], POLLIN, 0};
    return poll(&input, 1, 0) > 0;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

struct BoardBench {
  explicit BoardBench(bool at_terminal = false) : keys(at_terminal) {}

  test::TemporaryFolder folder;
  test::ManualClock clock;
  Keys keys;
  Terminal line{keys.input()};
  RecordRequest request = request_in(folder);

  static RecordRequest request_in(const test::TemporaryFolder& folder) {
    RecordRequest request{read_cell(test::paper_cell_file()), {}, folder.path() / "recording"};
    request.cell.camera.width_px = request.cell.camera.height_px = kSide_px;
    request.board = parse_board("circles:5x4:10mm");
    for (const char* id : {"g1", "g2"})
      request.plan.push_back({id, Purpose::kHeldBoard, std::monostate()});
    request.plan.push_back({"l1", Purpose::kLaidBoard, std::monostate()});
    return request;
  }
  GuidedBoard guided(FrameSource& camera, const std::set<std::string>& present = {}) {
    return GuidedBoard(request, present, camera, clock, line, nullptr);
  }
};

const cv::Point kUpperLeft(110, 100), kLowerRight(690, 700), kMiddle(400, 400);

TEST_CASE("A view is taken from a board that stands still, the next one when it stands elsewhere") {
  BoardBench bench;
  const double begin_s = bench.clock.now_s();
  WatchedBoard camera(bench.clock, [&](double t_s) -> std::optional<cv::Point> {
    if (t_s < begin_s + 3.0) return cv::Point(110 + static_cast<int>(40.0 * (t_s - begin_s)), 100);
    return t_s < begin_s + 10.0 ? kUpperLeft : kLowerRight;
  });
  GuidedBoard board = bench.guided(camera);
  const Frame first = board.take(bench.request.plan[0], 0);
  CHECK(first.t_s - begin_s == Approx(3.7).margin(0.21));
  CHECK(first.image.size() == cv::Size(kSide_px, kSide_px));
  const Frame second = board.take(bench.request.plan[1], 1);
  CHECK(second.t_s - begin_s == Approx(10.7).margin(0.21));
}

TEST_CASE("The board held for the last view is not taken for a laid one") {
  BoardBench bench;
  WatchedBoard camera(bench.clock, [&](double t_s) { return t_s < 100.0 ? kUpperLeft : kMiddle; });
  bench.clock.sleep_for_s(10.0 - bench.clock.now_s());
  bench.request.plan.erase(bench.request.plan.begin());
  GuidedBoard board = bench.guided(camera);
  CHECK(board.take(bench.request.plan[0], 0).t_s < 12.0);
  CHECK(board.take(bench.request.plan[1], 0).t_s > 101.4);
}

TEST_CASE("Enter takes a view at once if there is a board, even one like a view before") {
  BoardBench bench(true);
  WatchedBoard camera(bench.clock, [](double) { return kMiddle; });
  GuidedBoard board = bench.guided(camera);
  board.take(bench.request.plan[0], 0);
  const double first_s = bench.clock.now_s();
  bool pressed = false;
  camera.fails = [&](double t_s) {
    if (!pressed && t_s > first_s + 30.0) bench.keys.press_enter();
    pressed = t_s > first_s + 30.0;
    return false;
  };
  CHECK(board.take(bench.request.plan[1], 1).t_s == Approx(first_s + 30.1).margin(0.11));
}

TEST_CASE("What a script sends takes no view and is left to the tracker") {
  BoardBench bench;
  bench.keys.press_enter();
  WatchedBoard camera(bench.clock, [](double) { return kMiddle; });
  CHECK(bench.guided(camera).take(bench.request.plan[0], 0).t_s > 0.7);
  CHECK(bench.keys.is_left());
}

TEST_CASE("Views that a recording holds are known again after a stop") {
  BoardBench bench;
  const double begin_s = bench.clock.now_s();
  make_folder(bench.request.recording / "images");
  cv::imwrite((bench.request.recording / "images/g1_0.pgm").string(),
              picture_with_board(kUpperLeft));
  write_file(bench.request.recording / "frames.csv",
             frames_header() + frame_line({"g1",
                                           "images/g1_0.pgm",
                                           0.0,
                                           Purpose::kHeldBoard,
                                           {},
                                           {},
                                           {0, 0, kSide_px, kSide_px}}));
  WatchedBoard camera(bench.clock,
                      [&](double t_s) { return t_s < begin_s + 30.0 ? kUpperLeft : kLowerRight; });
  GuidedBoard board = bench.guided(camera, {"g1"});
  CHECK(board.take(bench.request.plan[1], 1).t_s > begin_s + 30.0);
}

TEST_CASE("Who waits for the board can be stopped, and gives up without camera or board") {
  BoardBench bench;
  WatchedBoard camera(bench.clock, [](double) { return std::nullopt; });
  camera.period_s = 2.0;
  const double begin_s = bench.clock.now_s();
  bench.request.stop = [&] { return bench.clock.now_s() > begin_s + 5.0; };
  CHECK_THROWS_MATCHES(bench.guided(camera).take(bench.request.plan[0], 0), WorkError,
                       Refused(Cause::kStopped, "g1"));
  bench.request.stop = {};
  CHECK_THROWS_MATCHES(bench.guided(camera).take(bench.request.plan[0], 0), WorkError,
                       Refused(Cause::kInsufficient, "g1"));
  camera.fails = [](double) { return true; };
  CHECK_THROWS_MATCHES(bench.guided(camera).take(bench.request.plan[0], 0), WorkError,
                       Refused(Cause::kDevice, "g1"));
}

TEST_CASE("A camera that fails for a while does not end the work") {
  BoardBench bench;
  const double begin_s = bench.clock.now_s();
  WatchedBoard camera(bench.clock, [](double) { return kMiddle; });
  camera.fails = [&](double t_s) { return t_s < begin_s + 20.0; };
  CHECK(bench.guided(camera).take(bench.request.plan[0], 0).t_s < begin_s + 30.0);
}

TEST_CASE("The arm waits until the board has been gone for five seconds") {
  BoardBench bench;
  const double begin_s = bench.clock.now_s();
  WatchedBoard camera(bench.clock, [&](double t_s) -> std::optional<cv::Point> {
    return t_s < begin_s + 10.0 ? std::optional(kMiddle) : std::nullopt;
  });
  bench.guided(camera).clear_field();
  CHECK(bench.clock.now_s() - begin_s == Approx(15.0).margin(0.21));
}

TEST_CASE("At a terminal the arm waits for Enter, and for the board to be gone") {
  BoardBench bench(true);
  WatchedBoard camera(bench.clock, [&](double t_s) -> std::optional<cv::Point> {
    return t_s < 10.0 ? std::optional(kMiddle) : std::nullopt;
  });
  camera.fails = [&](double t_s) {
    if (std::abs(t_s - 5.0) < 0.05 || std::abs(t_s - 30.0) < 0.05) bench.keys.press_enter();
    return false;
  };
  bench.guided(camera).clear_field();
  CHECK(bench.clock.now_s() == Approx(30.0).margin(0.11));
}

}  // namespace
}  // namespace planar
