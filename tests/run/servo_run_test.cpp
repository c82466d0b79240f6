#include "planar_servo/work/run/servo_run.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/run_files.h"
#include "run/hiccup_cell.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/unhomed_cell.h"

namespace planar {
namespace {

using test::Refused;

/// A drive that fails on its first move and, once the camera was asked, on every further one.
class FlakyDrive final : public PulseDrive {
 public:
  explicit FlakyDrive(Clock& clock) : clock_(clock), drive_(clock) {}

  bool fails{true};
  bool by_hand{false};  ///< a person stops it
  int failures{0};
  double recovery_s{0.0};  ///< what it takes to switch it on after a failure

  void energize() override {
    if (failures > 0) clock_.sleep_for_s(recovery_s);
    drive_.energize();
  }
  void set_limits(const DriveLimits& limits) override { drive_.set_limits(limits); }
  void set_target(std::int32_t target_pulses) override { drive_.set_target(target_pulses); }
  void halt() override {
    drive_.halt();
    if (!std::exchange(failing_, false)) return;
    if (++failures == 1) fails = false;
  }
  DriveStatus status() override {
    DriveStatus status = drive_.status();
    failing_ = fails && status.moving;
    if (failing_) status.faults.emplace_back("its link is down");
    status.stopped_by_hand = failing_ && by_hand;
    return status;
  }
  void start_homing(HomeDirection direction) override { drive_.start_homing(direction); }
  void set_position(std::int32_t position_pulses) override { drive_.set_position(position_pulses); }
  void forget_position() override { drive_.forget_position(); }

 private:
  Clock& clock_;
  test::MockPulseDrive drive_;
  bool failing_{false};
};

/// A camera that loses its first frame and has none afterwards.
class LostCamera final : public FrameSource {
 public:
  explicit LostCamera(FlakyDrive& drive) : drive_(drive) {}

  int asked{0};
  int takes_drive_along{1000};  ///< at so many looks the drive fails, too
  bool flaps{false};            ///< is at fault every other time that it is asked

  cv::Size sensor_size_px() const override { return {5120, 5120}; }
  void set_region(const cv::Rect& /*region_px*/) override {}
  FrameResult next_frame() override {
    ++asked;
    drive_.fails = asked <= takes_drive_along;
    return {FrameStatus::kLost, {}};
  }
  std::optional<std::string> fault() const override {
    faulty_ = flaps && !faulty_;
    return faulty_ ? std::optional<std::string>("a loose plug") : std::nullopt;
  }
  FrameCounts counts() const override { return {}; }
  CameraExposure exposure() const override { return {}; }
  void set_exposure(const CameraExposure& /*exposure*/) override {}

 private:
  FlakyDrive& drive_;
  mutable bool faulty_{false};
};

class FlakyCell final : public CellDevices {
 public:
  FlakyDrive flaky{clock_};
  LostCamera lost{flaky};

  Clock& clock() override { return clock_; }
  FrameSource& camera() override { return lost; }
  DriveGroup& drives() override { return drives_; }
  Tracker& tracker() override { throw WorkError("no tracker", Cause::kMissing); }
  BoardPresenter* board_presenter() override { return nullptr; }
  std::shared_ptr<Judge> truth() override { return nullptr; }

 private:
  test::ManualClock clock_;
  test::MockPulseDrive second_{clock_}, third_{clock_};
  SeparateDrives drives_{{&flaky, &second_, &third_}};
};

constexpr char kCamera[] = R"(image_width: 5120
image_height: 5120
camera_matrix: {rows: 3, cols: 3, data: [4000, 0, 2560, 0, 4000, 2560, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
)";

/// The paper's cell with an ideal camera above it and an ideal tool.
CellSettings ideal_cell(const test::TemporaryFolder& folder) {
  CellSettings cell = read_cell(test::paper_cell_file());
  WorkplaneRecord plane;
  plane.X_WC.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  plane.X_WC.translation() = Eigen::Vector3d(0.0, 0.0, 1.2);
  cell.camera_model = folder.write("camera.yaml", kCamera);
  cell.workplane = folder.write("workplane.yaml", workplane_text(plane, "test", {}));
  cell.tool = folder.write("tool.yaml", tool_text({}, "test", {}));
  return cell;
}

std::shared_ptr<const CalibratedCell> without_map(const CellSettings& cell) {
  return std::make_shared<CalibratedCell>(read_calibrated_cell(cell, false));
}

/// Asks for a run of that cell without an error map.
ServoRequest ideal_request(const test::TemporaryFolder& folder) {
  ServoRequest request;
  request.cell = without_map(ideal_cell(folder));
  request.folder.path = folder / "run";
  return request;
}

/// Begins a run and moves to a target; what fails ends the run.
void run_to_a(const ServoRequest& request, CellDevices& devices) {
  ServoRun(request, devices).move_to({"a", {0.3, 0.2}, std::nullopt});
}

/// Drives that count from anywhere, and a camera without a frame.
class LeftCell final : public test::UnhomedCell {
 public:
  LeftCell(const CellSettings& cell, std::mt19937& random) : UnhomedCell(cell) {
    std::uniform_int_distribution<std::int32_t> left(-3000000, 3000000);
    for (test::MockPulseDrive& drive : motors) {
      drive.set_position(left(random));
      drive.knows_position = false;
    }
  }

  FrameSource& camera() override { return lost_; }

 private:
  FlakyDrive unused_{test::UnhomedCell::clock()};
  LostCamera lost_{unused_};
};

TEST_CASE("Whatever a board counts, its drives home before anything is planned, or nothing moves") {
  const test::TemporaryFolder folder;
  std::mt19937 random(37);
  CellSettings cell = ideal_cell(folder);
  for (MotorDrive& drive : cell.transmission.drives) drive.home = HomeReference::kReverseSwitch;
  ServoRequest request = ideal_request(folder);
  request.cell = without_map(cell);
  for (int start = 0; start < 200; ++start) {
    LeftCell devices(cell, random);
    const bool allowed = start % 2 == 0;
    request.policy.checks_health = start % 4 < 2;
    request.may_home = [&](Homing /*way*/, const std::string& unhomed) {
      CHECK(unhomed == "drives that have lost their position: 1 2 3");
      for (const test::MockPulseDrive& drive : devices.motors) CHECK(drive.targets.empty());
      return allowed;
    };
    const std::string ended = !allowed                       ? "--home"
                              : request.policy.checks_health ? "no picture"
                                                             : "60 s";
    CHECK_THROWS_MATCHES(run_to_a(request, devices), WorkError, Refused(Cause::kDevice, ended));
    for (const test::MockPulseDrive& drive : devices.motors) {
      CHECK(drive.targets.empty() != allowed);
      if (allowed) CHECK(drive.targets.front() == -test::MockPulseDrive::kSwitch_pulses);
    }
    std::filesystem::remove_all(request.folder.path);
  }
}

/// Sends an arm whose drive always fails to a target, and expects that it gives up by an `Error`
/// after so many failures and looks.
template <typename Error>
void expect_given_up(FlakyCell& devices, int failures, int looks) {
  const test::TemporaryFolder folder;
  ServoRequest request = ideal_request(folder);
  request.policy.checks_health = false;
  ServoRun run(request, devices);
  CHECK_THROWS_AS(run.move_to({"a", {0.3, 0.2}, std::nullopt}), Error);
  CHECK(devices.lost.asked == looks);
  CHECK(devices.flaky.failures == failures);
  CHECK_FALSE(run.has("a"));
}

TEST_CASE("A drive is waited for three times on the way to a target, whatever the camera does") {
  FlakyCell devices;
  expect_given_up<DriveError>(devices, 4, 1);
}

TEST_CASE("An arm that a person stops is not switched on again by the run") {
  FlakyCell devices;
  devices.flaky.by_hand = true;
  expect_given_up<StoppedByHand>(devices, 1, 0);
}

TEST_CASE("A run that fails before the arm moves to a target leaves no folder, a later one does") {
  const test::TemporaryFolder folder;
  FlakyCell devices;
  ServoRequest request = ideal_request(folder);
  CHECK_THROWS_AS(run_to_a(request, devices), WorkError);
  CHECK_FALSE(std::filesystem::exists(request.folder.path));
  request.policy.checks_health = false;
  FlakyCell others;
  others.lost.takes_drive_along = 0;
  CHECK_THROWS_AS(run_to_a(request, others), WorkError);
  CHECK(std::filesystem::exists(request.folder.path / "steps.csv"));
}

TEST_CASE("A camera that is not back within a minute ends the run without a result of the target") {
  const test::TemporaryFolder folder;
  FlakyCell devices;
  devices.lost.takes_drive_along = 0;
  ServoRequest request = ideal_request(folder);
  request.policy.checks_health = false;
  request.accepted.doubts = true;
  ServoRun run(request, devices);
  const double start_s = devices.clock().now_s();
  CHECK_THROWS_MATCHES(run.move_to({"a", {0.3, 0.2}, std::nullopt}), WorkError,
                       Refused(Cause::kDevice, "60 s"));
  CHECK(devices.clock().now_s() - start_s >= 60.0);
  CHECK_FALSE(run.has("a"));
}

TEST_CASE("A camera is waited for in full after a drive was waited for") {
  for (const bool drive_first : {true, false}) {
    const test::TemporaryFolder folder;
    FlakyCell devices;
    devices.flaky.fails = drive_first;
    devices.lost.takes_drive_along = drive_first ? 0 : 1;
    devices.flaky.recovery_s = 70.0;
    ServoRequest request = ideal_request(folder);
    request.policy.checks_health = false;
    ServoRun run(request, devices);
    const double start_s = devices.clock().now_s();
    CHECK_THROWS_AS(run.move_to({"a", {0.3, 0.2}, std::nullopt}), WorkError);
    CHECK(devices.flaky.failures == 1);
    CHECK(devices.clock().now_s() - start_s >= 130.0);
  }
}

/// A judge that takes longer than a camera is waited for.
class SlowJudge final : public Judge {
 public:
  static constexpr double kSlow_s = 70.0;

  explicit SlowJudge(Clock& clock) : clock_(clock) {}

  std::function<void()> after_first;
  int asked{0};

  JudgeKind kind() const override { return JudgeKind::kTracker; }
  JudgedTip judge(const std::string& /*id*/, const Standing& standing) override {
    clock_.sleep_for_s(kSlow_s);
    if (++asked == 1) after_first();
    return {standing.seen.value().p, 1e-6, "", std::nullopt};
  }
  double common_sigma() const override { return 0.0; }

 private:
  Clock& clock_;
};

TEST_CASE("A camera is waited for in full after a long judgement") {
  const test::TemporaryFolder folder;
  const CellSettings cell = read_cell(test::workshop_cell_file());
  test::HiccupCell devices(cell);
  double well_s = 0.0;
  devices.hiccup.fails = [&] { return devices.clock().now_s() < well_s; };
  ServoRequest request;
  request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  request.folder.path = folder / "run";
  request.policy.checks_health = false;
  const auto judge = std::make_shared<SlowJudge>(devices.clock());
  judge->after_first = [&] { well_s = devices.clock().now_s() + 2.0; };
  request.judge = judge;
  ServoRun run(request, devices);
  const TargetResult& result = run.move_to({"a", {0.2, 0.1}, std::nullopt});
  CHECK(result.status == ServoStatus::kReached);
  CHECK(judge->asked == 2);
  CHECK(result.seconds < SlowJudge::kSlow_s);  // less the time of judging
}

TEST_CASE("A camera that comes and goes is waited for twenty times at a target") {
  const test::TemporaryFolder folder;
  FlakyCell devices;
  devices.flaky.fails = false;
  devices.lost.flaps = true;
  ServoRequest request = ideal_request(folder);
  request.policy.checks_health = false;
  ServoRun run(request, devices);
  CHECK_THROWS_MATCHES(run.move_to({"a", {0.3, 0.2}, std::nullopt}), WorkError,
                       Refused(Cause::kDevice, "21 times"));
  CHECK_FALSE(run.has("a"));
}

TEST_CASE("While the cell is looked at, drive and camera are waited for, but not for ever") {
  const test::TemporaryFolder folder;
  FlakyCell devices;
  ServoRun run(ideal_request(folder), devices);
  CHECK_THROWS_MATCHES(run.move_to({"a", {0.3, 0.2}, std::nullopt}), WorkError,
                       Refused(Cause::kDevice, "no picture"));
  CHECK(devices.flaky.failures == 1);
  CHECK(devices.lost.asked > 2);
  // A check that failed is none: the next move begins with it again.
  devices.lost.takes_drive_along = 0;
  devices.flaky.fails = false;
  CHECK_THROWS_MATCHES(run.move_to({"a", {0.3, 0.2}, std::nullopt}), WorkError,
                       Refused(Cause::kDevice, "no picture"));
  CHECK_FALSE(run.has("a"));
}

TEST_CASE("A run without a folder reaches its target and writes nothing") {
  const CellSettings cell = read_cell(test::workshop_cell_file());
  const auto devices = open_cell(cell);
  const test::TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  ServoRequest request;
  request.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(cell));
  request.policy.checks_health = false;
  ServoRun run(request, *devices);
  const TargetResult result = run.move_to({"a", {0.2, 0.1}, std::nullopt});
  run.finish();
  std::filesystem::current_path(before);
  CHECK(result.status == ServoStatus::kReached);
  CHECK(run.results().size() == 1);
  CHECK(std::filesystem::is_empty(folder.path()));
}

/// A folder with a run that has one result, at the target 'a'.
struct BegunRun {
  BegunRun() {
    std::filesystem::create_directories(request.folder.path);
    TargetResult result;
    result.id = "a";
    result.p_d = {0.3, 0.2};
    result.phi_d = 0.5;
    GrowingFile(request.folder.path / "results.csv", results_header(run_remarks(request)))
        .append(result_line(result));
    request.folder.resume = true;
  }

  test::TemporaryFolder folder;
  ServoRequest request{ideal_request(folder)};
};

TEST_CASE("A run is resumed with the settings of its servo, and with no others") {
  BegunRun begun;
  CHECK(results_so_far(begun.request).size() == 1);
  CellSettings changed = begun.request.cell->settings;
  SECTION("the gain") {
    changed.servo.gain = 0.5;
  }
  SECTION("the tolerance") {
    changed.servo.tolerance_m = 7e-6;
  }
  SECTION("the way in which lamps' centres are measured") {
    begun.request.policy.center = CenterMethod::kFast;
  }
  begun.request.cell = without_map(changed);
  CHECK_THROWS_MATCHES(results_so_far(begun.request), InputError,
                       Refused(Cause::kForeign, "servo settings"));
}

TEST_CASE(
    "A run is resumed with the cell's tools, however many, as they were, and with no others") {
  const test::TemporaryFolder folder;
  ServoRequest request = ideal_request(folder);
  CellSettings cell = request.cell->settings;
  for (int i = 0; i < 20; ++i) {
    const std::string name = "tool" + std::to_string(i);
    cell.tools[name] = folder.write(name + ".yaml", "p_TE_mm: [1, 2]\n");
  }
  request.cell = without_map(cell);
  request.folder.resume = true;
  std::filesystem::create_directories(request.folder.path);
  write_file(results_file(request), results_header(run_remarks(request)));
  CHECK_NOTHROW(results_so_far(request));
  folder.write("tool9.yaml", "p_TE_mm: [1, 3]\n");
  CHECK_THROWS_MATCHES(results_so_far(request), InputError, Refused(Cause::kForeign, "tool9.yaml"));
}

TEST_CASE("A result is that of a target with its place and its direction, whole turns aside") {
  BegunRun begun;
  const std::vector<TargetResult> results = results_so_far(begun.request);
  CHECK_NOTHROW(require_same_goal("a", {{0.3, 0.2}, 0.5}, results));
  CHECK_NOTHROW(require_same_goal("a", {{0.3, 0.2}, 0.5 - 2.0 * kPi}, results));
  CHECK_NOTHROW(require_same_goal("b", {{0.3, 0.2}, 0.6}, results));
  CHECK_THROWS_MATCHES(require_same_goal("a", {{0.3, 0.2}, 0.501}, results), InputError,
                       Refused(Cause::kForeign, "28.705186 degrees"));
  CHECK_THROWS_MATCHES(require_same_goal("a", {{0.3, 0.21}, 0.5}, results), InputError,
                       Refused(Cause::kForeign, "(300.000, 210.000) mm"));
}

TEST_CASE("A run that was killed before its first result is resumed, one never begun is not") {
  const test::TemporaryFolder folder;
  ServoRequest request = ideal_request(folder);
  request.folder.resume = true;
  const Refused none(Cause::kMissing, "--resume");
  CHECK_THROWS_MATCHES(folder_for(request), InputError, none);
  std::filesystem::create_directories(request.folder.path);
  CHECK_NOTHROW(folder_for(request));
  folder.write("run/letter.txt", "dear");
  CHECK_THROWS_MATCHES(folder_for(request), InputError, none);
  folder.write("run/steps.csv", steps_header());
  CHECK_NOTHROW(folder_for(request));
  CHECK(results_so_far(request).empty());
  folder.write("run/results.csv", "");
  CHECK(results_so_far(request).empty());
}

TEST_CASE("A run whose report would replace what is not ours is refused before it begins") {
  const test::TemporaryFolder folder;
  const ServoRequest request = ideal_request(folder);
  std::filesystem::create_directories(request.folder.path);
  const std::string name = GENERATE(as<std::string>(), "run.yaml", "report.html");
  folder.write("run/" + name, "mine\n");
  CHECK_THROWS_MATCHES(folder_for(request), InputError, Refused(Cause::kExists, name));
}

}  // namespace
}  // namespace planar
