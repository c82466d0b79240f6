#include "planar_servo/work/record/recorder.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <sstream>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

/// A small dark camera, a tracker that reads zeros, and a board whose views are noted.
class NotingDevices final : public CellDevices,
                            public FrameSource,
                            public Tracker,
                            public BoardPresenter {
 public:
  std::vector<int> held, laid;
  std::optional<double> camera_dies_s;  ///< on the clock
  double camera_is_back_s{std::numeric_limits<double>::infinity()};

  bool moves() {
    const auto status = group_.status();
    return std::any_of(status.begin(), status.end(), [](const auto& s) { return s.moving; });
  }

  /// Lets a drive move for ever without arriving.
  void stall() { drives_[1].stalls = true; }

  Clock& clock() override { return clock_; }
  FrameSource& camera() override { return *this; }
  DriveGroup& drives() override { return group_; }
  Tracker& tracker() override { return *this; }
  BoardPresenter* board_presenter() override { return this; }
  std::shared_ptr<Judge> truth() override { return nullptr; }

  cv::Size sensor_size_px() const override { return {64, 64}; }
  void set_region(const cv::Rect& /*region_px*/) override {}
  FrameResult next_frame() override {
    clock_.sleep_for_s(0.1);
    if (fault()) return {FrameStatus::kTimeout, {}};
    return {FrameStatus::kOk, {cv::Mat::zeros(64, 64, CV_8UC1), {0, 0, 64, 64}, clock_.now_s(), 0}};
  }

  std::optional<std::string> fault() const override {
    const double now_s = clock_.now_s();
    if (!camera_dies_s || now_s < *camera_dies_s || now_s >= camera_is_back_s) return std::nullopt;
    return "the camera is dead";
  }
  FrameCounts counts() const override { return {}; }

  CameraExposure exposure() const override { return {}; }
  void set_exposure(const CameraExposure& /*exposure*/) override {}

  /// What the tracker says of the tool, one after the other; then readings that follow it.
  std::vector<TrackerAnswer> answers;
  std::vector<std::string> asked;    ///< places and monuments, in their order
  double dead_after_reading_s{0.0};  ///< the camera, for so long
  std::string skipped;               ///< this monument is
  bool stands_elsewhere{false};      ///< what the tracker reads

  TrackerAnswer measure_tool(const std::string& place) override {
    asked.push_back(place);
    if (dead_after_reading_s > 0.0) {
      camera_dies_s = clock_.now_s();
      camera_is_back_s = *camera_dies_s + dead_after_reading_s;
    }
    readings_ += 1.0;
    if (stands_elsewhere) return {TrackerStatus::kElsewhere};
    if (answers.empty()) return TrackerAnswer::of({0.0, {readings_, 0.0, 0.0}});
    TrackerAnswer answer = answers.front();
    answers.erase(answers.begin());
    return answer;
  }
  void await_tool() override { asked.push_back("tool"); }
  TrackerAnswer measure_monument(const std::string& id) override {
    asked.push_back(id);
    if (stands_elsewhere) return {TrackerStatus::kElsewhere};
    return id == skipped ? TrackerAnswer{TrackerStatus::kSkipped} : TrackerAnswer::of({});
  }

  void hold_board(int view) override {
    held.push_back(view);
    asked.emplace_back("board");
  }
  void lay_board(int view) override { laid.push_back(view); }
  void remove_board() override {}

 private:
  double readings_{0.0};
  test::ManualClock clock_;
  std::array<test::MockPulseDrive, 3> drives_{
      test::MockPulseDrive(clock_), test::MockPulseDrive(clock_), test::MockPulseDrive(clock_)};
  SeparateDrives group_{{&drives_[0], &drives_[1], &drives_[2]}};
};

using Ids = std::vector<std::string>;

/// The paper's cell with the camera of NotingDevices.
CellSettings small_cell() {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.camera.width_px = cell.camera.height_px = 64;
  return cell;
}

TEST_CASE("An interrupted recording resumes with the board's next views") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  for (const char* id : {"g0", "g1"})
    request.plan.push_back({id, Purpose::kHeldBoard, std::monostate()});
  request.plan.push_back({"p0", Purpose::kLaidBoard, std::monostate()});
  NotingDevices first;
  CHECK(record(request, first).recorded == 3);
  CHECK(first.held == std::vector<int>{0, 1});
  CHECK(first.laid == std::vector<int>{0});

  for (const char* id : {"g2", "g3"})
    request.plan.push_back({id, Purpose::kHeldBoard, std::monostate()});
  NotingDevices second;
  const RecordReport report = record(request, second);
  CHECK(report.present == 3);
  CHECK(report.recorded == 2);
  CHECK(second.held == std::vector<int>{2, 3});
  CHECK(second.laid.empty());
}

TEST_CASE("A camera that is not back within a minute ends the recording, which can be resumed") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"g0", Purpose::kHeldBoard, std::monostate()});
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  NotingDevices devices;
  devices.camera_dies_s = devices.clock().now_s() + 0.5;  // the move takes seconds
  CHECK_THROWS_MATCHES(record(request, devices), WorkError,
                       Refused(Cause::kDevice, "t0: the camera is dead"));
  CHECK(devices.clock().now_s() < *devices.camera_dies_s + 62.0);
  CHECK_FALSE(devices.moves());
  NotingDevices again;
  CHECK(record(request, again).present == 1);
}

TEST_CASE("A camera that fails on the way or at a place is waited for, and the recording goes on") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"g0", Purpose::kHeldBoard, std::monostate()});
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  NotingDevices devices;
  devices.camera_dies_s = devices.clock().now_s() + GENERATE(-1.0, 0.5);
  devices.camera_is_back_s = *devices.camera_dies_s + 30.0;
  CHECK(record(request, devices).recorded == 2);
  CHECK(devices.clock().now_s() >= devices.camera_is_back_s);
}

TEST_CASE("A cell with fixed lamps is recorded with a whole frame twice a minute") {
  const test::TemporaryFolder folder;
  RecordRequest request{read_cell(test::workshop_cell_file()), {}, folder.path() / "recording"};
  request.cell.servo.settle_s = 4.0;
  for (int i = 0; i < 24; ++i)
    request.plan.push_back({"t" + std::to_string(i), Purpose::kTrain,
                            TipPose{0.3 * rotation2d(0.25 * i).col(0), 0.0}});
  record(request, *open_cell(request.cell));
  std::vector<double> whole_s;
  const std::vector<FrameRow> frames = read_frames(request.recording);
  for (const FrameRow& frame : frames)
    if (frame.region_px.width == request.cell.camera.width_px) whole_s.push_back(frame.t_s);
  REQUIRE(whole_s.size() > 3);
  CHECK(whole_s.size() < frames.size() / 3);
  const double place_s = frames.back().t_s / static_cast<double>(request.plan.size());
  for (std::size_t i = 1; i < whole_s.size(); ++i)
    CHECK(whole_s[i] - whole_s[i - 1] < kReferencePeriod_s + 2.0 * place_s);
  CHECK(frames.back().t_s - whole_s.back() < kReferencePeriod_s + 2.0 * place_s);
}

TEST_CASE("The monuments are read before the arm moves and once more at the end") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  NotingDevices devices;
  record(request, devices);
  std::string order;
  for (const TrackerRow& row : read_tracker(request.recording / "tracker.csv"))
    order += row.id == "t0" ? 't' : 'm';
  CHECK(order == std::string(15, 'm') + 't' + std::string(15, 'm'));
}

TEST_CASE("What is missing of the monuments at the end is read by the next run, and no more") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  NotingDevices devices;
  record(request, devices);
  const std::filesystem::path table = request.recording / "tracker.csv";
  const std::string whole = read_file(table);
  std::string torn = whole;
  for (int i = 0; i < 7; ++i) torn.erase(torn.rfind('\n', torn.size() - 2) + 1);
  write_file(table, torn + "datum");
  NotingDevices again;
  const RecordReport report = record(request, again);
  CHECK(report.recorded == 0);
  CHECK(report.monuments.empty());
  CHECK(again.asked.size() == 7);
  CHECK(read_file(table) == whole);
  NotingDevices third;
  record(request, third);
  CHECK(third.asked.empty());
}

TEST_CASE(
    "Views of the board at the end need no tracker: monuments come first, and the arm parks") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  request.plan.push_back({"g0", Purpose::kHeldBoard, std::monostate()});
  request.plan.push_back({"g1", Purpose::kHeldBoard, std::monostate()});
  NotingDevices devices;
  devices.dead_after_reading_s = GENERATE(0.0, 20.0);  // the arm parks all the same
  record(request, devices);
  REQUIRE(devices.asked.size() == 15 + 2 + 15 + 2);  // monuments, tool and place, monuments, views
  CHECK(Ids(devices.asked.end() - 3, devices.asked.end()) == Ids{"datum3", "board", "board"});
  const Joints parked = read_frames(request.recording).back().theta;
  const Eigen::Vector2d p = PlanarArm(request.cell.arm.geometry).forward(parked).p;
  const double rim_m = request.cell.workspace.radius_max_m;
  CHECK(p.norm() > 0.9 * rim_m);
  CHECK(p.norm() < rim_m);
  CHECK((p - PlanarArm(request.cell.arm.geometry).forward(request.cell.arm.home).p).norm() <
        0.2 * rim_m);

  request.plan.push_back({"g2", Purpose::kHeldBoard, std::monostate()});
  NotingDevices later;
  CHECK(record(request, later).recorded == 1);
  CHECK(later.asked == Ids{"board"});
}

TEST_CASE("Views of the board before the last reading leave the arm and the monuments alone") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  request.plan.push_back({"g0", Purpose::kHeldBoard, std::monostate()});
  request.plan.push_back({"t1", Purpose::kTrain, TipPose{{0.2, 0.3}, 0.0}});
  NotingDevices devices;
  record(request, devices);
  const std::vector<FrameRow> frames = read_frames(request.recording);
  const auto board = std::find_if(frames.begin(), frames.end(),
                                  [](const FrameRow& row) { return row.id == "g0"; });
  CHECK(board->theta == frames.front().theta);
  const auto& asked = devices.asked;
  CHECK(*(std::find(asked.begin(), asked.end(), "board") + 1) == "t1");
}

TEST_CASE("Drives that do not arrive name the place, and the recording can be resumed") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  NotingDevices devices;
  devices.stall();
  CHECK_THROWS_MATCHES(record(request, devices), DriveError, Refused(Cause::kDevice, "t0: "));
  NotingDevices mended;
  CHECK(record(request, mended).recorded == 1);
}

TEST_CASE("Who left after monuments is asked for the reflector on the tool, after places nobody") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan = {{"u0", Purpose::kPose, TipPose{{-0.2, 0.3}, 0.0}}};
  NotingDevices unattended;
  record(request, unattended);
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  const auto asked_before_a_failure = [&](double camera_dies_s) {
    NotingDevices devices;
    devices.camera_dies_s = camera_dies_s;
    CHECK_THROWS_AS(record(request, devices), WorkError);
    return devices.asked;
  };
  CHECK(asked_before_a_failure(0.0).back() == "tool");
  CHECK(asked_before_a_failure(0.0) == Ids{"tool"});
  NotingDevices devices;
  record(request, devices);
  CHECK(devices.asked.front() == "tool");
  for (const char* id : {"t1", "t2"})
    request.plan.push_back({id, Purpose::kTrain, TipPose{{0.2, 0.3}, 0.0}});
  NotingDevices later;  // the monuments were read at the end
  later.answers.push_back(TrackerAnswer::of({}));
  later.answers.resize(4, TrackerAnswer::failed("the beam is broken"));
  CHECK_THROWS_AS(record(request, later), WorkError);
  CHECK(Ids(later.asked.begin(), later.asked.begin() + 2) == Ids{"tool", "t1"});
  NotingDevices last;
  record(request, last);
  CHECK(last.asked.front() == "t2");
}

TEST_CASE("Where readings stand elsewhere, monuments read again end with the reflector's return") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  for (const char* id : {"t0", "t1"}) {
    request.plan.push_back({id, Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
    NotingDevices devices;
    devices.stands_elsewhere = true;
    record(request, devices);
    CHECK(*(std::find(devices.asked.begin(), devices.asked.end(), id) - 1) == "tool");
  }
}

TEST_CASE("No reading is asked for at a pose that only the camera watches") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  request.plan.push_back({"u0", Purpose::kPose, TipPose{{-0.2, 0.2}, 0.4}});
  NotingDevices devices;
  CHECK(record(request, devices).recorded == 2);
  const auto frames = read_frames(request.recording);
  CHECK(frames.back().id == "u0");
  CHECK(frames.back().plan == Purpose::kPose);
  for (const TrackerRow& row : read_tracker(request.recording / "tracker.csv"))
    CHECK(row.id != "u0");
}

TEST_CASE("A recording is not resumed by another plan or another cell") {
  const test::TemporaryFolder folder;
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  request.plan.push_back({"t1", Purpose::kTrain, TipPose{{0.2, 0.3}, 0.0}});
  NotingDevices devices;
  record(request, devices);
  const auto again = [&](const auto& change) {
    RecordRequest other = request;
    change(other);
    NotingDevices fresh;
    record(other, fresh);
  };
  CHECK_NOTHROW(again([](RecordRequest& r) {
    r.plan.push_back({"t2", Purpose::kTest, TipPose{{0.1, 0.3}, 0.0}});
  }));
  CHECK_THROWS_MATCHES(again([](RecordRequest& r) {
                         r.plan[1].where = TipPose{{0.2, 0.31}, 0.0};
                       }),
                       InputError, Refused(Cause::kForeign, "frames.csv: 't1'"));
  CHECK_THROWS_MATCHES(again([](RecordRequest& r) { r.plan[0].plan = Purpose::kTest; }), InputError,
                       Refused(Cause::kForeign, "plan test"));
  CHECK_THROWS_MATCHES(
      again([](RecordRequest& r) { r.cell.arm.geometry.link_lengths_m.x() += 1e-3; }), InputError,
      Refused(Cause::kForeign, "frames.csv: 't0'"));
  CHECK_THROWS_MATCHES(
      again([](RecordRequest& r) { r.cell.transmission.drives[0].gear_ratio *= 1.01; }), InputError,
      Refused(Cause::kForeign, "drives"));
  CHECK_THROWS_MATCHES(again([](RecordRequest& r) { r.cell.camera.width_px = 128; }), InputError,
                       Refused(Cause::kForeign, "64 x 64 px"));
  CHECK_THROWS_MATCHES(again([](RecordRequest& r) { r.cell.datum.front().id = "d9"; }), InputError,
                       Refused(Cause::kForeign, "'d9'"));
}

RecordRequest two_places(const test::TemporaryFolder& folder) {
  RecordRequest request{small_cell(), {}, folder.path() / "recording"};
  request.plan.push_back({"t0", Purpose::kTrain, TipPose{{-0.2, 0.3}, 0.0}});
  request.plan.push_back({"t1", Purpose::kTrain, TipPose{{0.2, 0.3}, 0.0}});
  return request;
}

std::vector<std::string> ids_in_tables(const RecordRequest& request) {
  std::vector<std::string> ids;
  for (const FrameRow& row : read_frames(request.recording))
    if (ids.empty() || ids.back() != row.id) ids.push_back(row.id);
  for (const TrackerRow& row : read_tracker(request.recording / "tracker.csv"))
    if (row.id[0] == 't') ids.push_back(row.id);
  return ids;
}

/// Returns what is logged meanwhile.
std::string said_by(const std::function<void()>& deed) {
  std::ostringstream said;
  const auto usual = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  deed();
  spdlog::set_default_logger(usual);
  return said.str();
}

TEST_CASE("A place whose program was killed between its reading and its frames has one reading") {
  const test::TemporaryFolder folder;
  const RecordRequest request = two_places(folder);
  NotingDevices killed;
  record(request, killed);
  const std::string id = GENERATE(as<std::string>(), "t0", "t1");
  const auto cut = [&](const char* table, bool behind) {
    const std::filesystem::path file = request.recording / table;
    const std::string text = read_file(file);
    const std::size_t row = text.find("\n" + id + ",") + 1;
    write_file(file, text.substr(0, behind ? text.find('\n', row) + 1 : row));
  };
  cut("frames.csv", false);
  cut("tracker.csv", true);
  NotingDevices again;
  const std::string told = said_by([&] { record(request, again); });
  CHECK(told.find(id + ": a reading without frames") != std::string::npos);
  CHECK(ids_in_tables(request) == Ids{"t0", "t1", "t0", "t1"});
}

TEST_CASE("Readings whose frames were lost are named and kept, and nothing is recorded over them") {
  const test::TemporaryFolder folder;
  const RecordRequest request = two_places(folder);
  NotingDevices devices;
  record(request, devices);
  const std::string readings = read_file(request.recording / "tracker.csv");
  std::filesystem::remove(request.recording / "frames.csv");
  NotingDevices again;
  CHECK_THROWS_MATCHES(record(request, again), InputError, Refused(Cause::kMissing, "t0, t1"));
  CHECK(again.asked.empty());
  CHECK(read_file(request.recording / "tracker.csv") == readings);
}

TEST_CASE("Frames come later than those of a clock that has begun anew since") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  NotingDevices before;
  record(request, before);
  request.plan.push_back({"t2", Purpose::kTrain, TipPose{{0.1, 0.3}, 0.0}});
  NotingDevices after;  // its clock begins at 0
  record(request, after);
  const std::vector<FrameRow> frames = read_frames(request.recording);
  CHECK(std::is_sorted(frames.begin(), frames.end(),
                       [](const FrameRow& a, const FrameRow& b) { return a.t_s < b.t_s; }));
  CHECK(frames.back().id == "t2");
}

TEST_CASE("A recording with a skipped monument, or a broken first round, can be continued") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  request.cell.datum.push_back({"datum4", {0.45, -0.45, 0.0}});
  NotingDevices devices;
  SECTION("skipped") {
    devices.skipped = "datum4";
    CHECK(record(request, devices).recorded == 2);
  }
  SECTION("broken off") {
    request.plan = {{"p0", Purpose::kPose, TipPose{{0.1, 0.3}, 0.0}}};
    CHECK(record(request, devices).recorded == 1);
    write_file(request.recording / "tracker.csv",
               tracker_header() + tracker_line({"datum1", 0.0, {0.1, 0.2, 0.3}}));
  }
  request.plan.push_back({"t2", Purpose::kTrain, TipPose{{0.1, 0.31}, 0.0}});
  NotingDevices again;
  CHECK(record(request, again).recorded == 1);
  // What was read before the first place in the broken round, perhaps from elsewhere, is gone.
  CHECK(read_tracker(request.recording / "tracker.csv").front().p_L.isZero());
}

TEST_CASE("A plan of readings is refused where the monuments cannot tie them to the base") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  std::string fault = "datum has 2 monuments";
  SECTION("too few") {
    request.cell.datum.pop_back();
  }
  SECTION("on one line") {
    for (Monument& monument : request.cell.datum) monument.p_B.x() = -0.45;
    request.cell.datum.back().p_B.y() = 0.0;
    fault = "one line";
  }
  SECTION("of one name") {
    request.cell.datum.back().id = request.cell.datum.front().id;
    fault = "'datum1' is named twice";
  }
  NotingDevices devices;
  CHECK_THROWS_MATCHES(record(request, devices), InputError, Refused(Cause::kMissing, fault));
  CHECK(devices.asked.empty());
}

TEST_CASE("A place with the id of a monument is refused, but not one that nobody reads") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  NotingDevices devices;
  request.plan[1].id = "datum2";
  CHECK_THROWS_MATCHES(record(request, devices), InputError, Refused(Cause::kExists, "'datum2'"));
  CHECK(devices.asked.empty());
  request.plan[1].plan = Purpose::kPose;
  CHECK(record(request, devices).recorded == 2);
}

TEST_CASE("A place without a good reading is taken again, and the third failure ends the work") {
  const test::TemporaryFolder folder;
  const RecordRequest request = two_places(folder);
  NotingDevices devices;
  devices.answers = {TrackerAnswer::failed("the beam is broken"),
                     TrackerAnswer::failed("the beam is broken")};
  CHECK(record(request, devices).recorded == 2);
  CHECK(ids_in_tables(request) == Ids{"t0", "t1", "t0", "t1"});

  const test::TemporaryFolder other;
  NotingDevices blind;
  blind.answers.assign(3, TrackerAnswer::failed("the beam is broken"));
  CHECK_THROWS_MATCHES(record(two_places(other), blind), WorkError,
                       Refused(Cause::kDevice, "'t0': the beam is broken"));
  CHECK_FALSE(blind.moves());
}

TEST_CASE("A place is left out on request, and the next run takes it") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  request.on_bad_reading = BadReading::kSkip;
  NotingDevices devices;
  devices.answers = {TrackerAnswer::failed("the beam is broken")};
  CHECK(record(request, devices).skipped == Ids{"t0"});
  CHECK(ids_in_tables(request) == Ids{"t1", "t1"});
  NotingDevices again;
  CHECK(record(request, again).recorded == 1);
  CHECK(ids_in_tables(request) == Ids{"t1", "t0", "t1", "t0"});
  request.on_bad_reading = BadReading::kStop;
  request.plan.push_back({"t2", Purpose::kTrain, TipPose{{0.1, 0.3}, 0.0}});
  again.answers = {TrackerAnswer::failed("the beam is broken")};
  CHECK_THROWS_MATCHES(record(request, again), WorkError, Refused(Cause::kDevice, "'t2'"));
}

TEST_CASE("A reading that stays while the tool moves is a repeated one and named") {
  const test::TemporaryFolder folder;
  const RecordRequest request = two_places(folder);
  NotingDevices devices;
  devices.answers.assign(4, TrackerAnswer::of({0.0, {2.5, 0.0, 0.0}}));
  CHECK_THROWS_MATCHES(record(request, devices), WorkError,
                       Refused(Cause::kDevice, "'t1': the reading repeats that of 't0'"));
}

TEST_CASE("A place where no lamps are seen is named at once, not when all are recorded") {
  const test::TemporaryFolder folder;
  NotingDevices devices;  // its pictures are black
  devices.answers.push_back(TrackerAnswer::of({}));
  devices.answers.resize(4, TrackerAnswer::failed("the beam is broken"));
  const std::string told =
      said_by([&] { CHECK_THROWS_AS(record(two_places(folder), devices), WorkError); });
  CHECK(told.find("t0: no pair of lamps is seen") != std::string::npos);
}

TEST_CASE("Somebody who measures by hand may skip a place, repeat it, or keep the reading") {
  const test::TemporaryFolder folder;
  const RecordRequest request = two_places(folder);
  NotingDevices devices;
  devices.answers = {
      {TrackerStatus::kRepeat}, {TrackerStatus::kElsewhere}, {TrackerStatus::kSkipped}};
  CHECK(record(request, devices).skipped == Ids{"t1"});
  CHECK(ids_in_tables(request) == Ids{"t0"});
}

TEST_CASE("Without a tracker what asks for a reading is refused, and the rest is recorded") {
  const test::TemporaryFolder folder;
  RecordRequest request = two_places(folder);
  for (const TrackerKind* kind : device_kinds().trackers)
    if (!kind->measures()) request.cell.tracker.kind = kind;
  NotingDevices devices;
  CHECK_THROWS_MATCHES(record(request, devices), InputError, Refused(Cause::kMissing, "'t0'"));
  CHECK_FALSE(std::filesystem::exists(request.recording));
  request.plan = {{"g0", Purpose::kHeldBoard, std::monostate()},
                  {"u0", Purpose::kPose, TipPose{{-0.2, 0.3}, 0.0}}};
  CHECK(record(request, devices).recorded == 2);
  CHECK(devices.asked == Ids{"board"});
}

}  // namespace
}  // namespace planar
