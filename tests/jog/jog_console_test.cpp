#include "planar_servo/work/jog/jog_console.h"

#include <catch2/catch.hpp>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/jog_bench.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/unhomed_cell.h"

namespace planar {
namespace {

using Catch::Contains;
using test::JogBench;
using test::Refused;

constexpr double kOnePulse_mm = 0.02;  // a pulse of the paper's cell moves the end point by 2 um

/// A cell whose camera fails at a moment of its clock.
class FailingCamera final : public CellDevices, public FrameSource {
 public:
  double dies_s{std::numeric_limits<double>::infinity()};

  explicit FailingCamera(const CellSettings& cell) : whole_(open_cell(cell)) {}
  Clock& clock() override { return whole_->clock(); }
  FrameSource& camera() override { return *this; }
  DriveGroup& drives() override { return whole_->drives(); }
  Tracker& tracker() override { return whole_->tracker(); }
  BoardPresenter* board_presenter() override { return whole_->board_presenter(); }
  std::shared_ptr<Judge> truth() override { return whole_->truth(); }

  cv::Size sensor_size_px() const override { return whole_->camera().sensor_size_px(); }
  void set_region(const cv::Rect& region_px) override { whole_->camera().set_region(region_px); }
  FrameResult next_frame() override { return whole_->camera().next_frame(); }
  std::optional<std::string> fault() const override {
    if (whole_->clock().now_s() < dies_s) return std::nullopt;
    return "the camera is dead";
  }
  FrameCounts counts() const override { return whole_->camera().counts(); }
  CameraExposure exposure() const override { return whole_->camera().exposure(); }
  void set_exposure(const CameraExposure& /*exposure*/) override {
    throw WorkError("the camera refuses an exposure of 1 us", Cause::kDevice);
  }

 private:
  std::unique_ptr<CellDevices> whole_;
};

TEST_CASE("A line becomes the command that it names, in SI, its joints counted from 0") {
  const auto turn = std::get<TurnCommand>(parse_arm_command(" joint  2 -15").value());
  CHECK(turn.joint == 1);
  CHECK(turn.angle == Approx(-15.0 * kDegree));
  CHECK(std::get<StepCommand>(parse_arm_command("y 2.5").value())
            .by_B.isApprox(Eigen::Vector2d(0.0, 2.5e-3)));
  CHECK(std::get<GoCommand>(parse_arm_command("go bin 2").value()).id == "bin 2");
  CHECK_FALSE(std::get<HomeCommand>(parse_arm_command("home").value()).joint);
  const auto exposure = std::get<ExposeCommand>(parse_arm_command("exposure 250 6").value());
  CHECK(exposure.time_s == Approx(250e-6));
  CHECK(exposure.gain_db == 6.0);
  for (const char* nothing : {"", "  ", "# a remark"}) CHECK_FALSE(parse_arm_command(nothing));
  for (const char* line : {"quit", "x 1\ny 1", "jonit 1 2", "joint 4 1", "x", "x nan", "mark 0"}) {
    INFO(line);
    CHECK_THROWS_AS(parse_arm_command(line), InputError);
  }
}

TEST_CASE("Before homing, and at a jog that needs it, the commands are named that lead on") {
  const test::TemporaryFolder folder;
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.transmission.drives[0].home = cell.transmission.drives[1].home =
      HomeReference::kReverseSwitch;
  cell.transmission.drives[2].home = HomeReference::kTaught;
  cell.transmission.drives[2].home_rad = 10.0 * kDegree;
  test::UnhomedCell devices(cell);
  for (test::MockPulseDrive& motor : devices.motors) motor.knows_position = false;
  std::vector<std::string> announced;
  JogConsole console(read_calibrated_cell(cell), devices, folder / "t.csv", {},
                     [&](const std::string& sentence) { announced.push_back(sentence); });
  CHECK_THAT(test::execute(console, "home").text, Contains("the drives are off"));
  const std::string to_do =
      "joint 1, joint 2: home the arm, which searches the home switches and moves it; "
      "turn joint 3 to its mark at 10.000 deg by hand, then give the command mark 3";
  CHECK(test::execute(console, "enable").text == "the drives are on; still to be homed: " + to_do);
  const auto refused = test::execute(console, "joint 1 1");
  CHECK_FALSE(refused.done);
  CHECK(refused.text == "drives do not know where they stand; " + to_do);
  CHECK(test::execute(console, "teach a").text == refused.text);
  CHECK(test::execute(console, "mark 3").done);
  CHECK(test::execute(console, "home").text == "2 joints homed");
  REQUIRE(announced.size() == 2);
  CHECK_THAT(announced[1], Contains("joint 2 searches its home switch") && Contains("180 s"));
  CHECK(test::execute(console, "enable").text == "the drives are on and know where they stand");
}

TEST_CASE("A camera that fails stops a jog, and the next one goes without it") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  FailingCamera devices(cell);
  JogConsole console(read_calibrated_cell(cell), devices, "");
  REQUIRE(test::execute(console, "enable").done);
  devices.dies_s = devices.clock().now_s() + 0.05;  // 15 deg take 0.45 s
  const auto stopped = test::execute(console, "joint 2 15");
  CHECK_FALSE(stopped.done);
  CHECK_THAT(stopped.text, Contains("the camera is dead; the arm has stopped at joints"));
  CHECK(test::execute(console, "joint 2 15").done);
}

TEST_CASE("A jog that is stopped says where the arm is, and the next one continues from there") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const auto devices = open_cell(cell);
  const double start_s = devices->clock().now_s();
  bool stop = false;
  JogConsole console(read_calibrated_cell(cell), *devices, "", [&] {
    return stop && devices->clock().now_s() > start_s + 0.05;  // 15 deg take 0.45 s
  });
  REQUIRE(test::execute(console, "enable").done);
  stop = true;
  const auto stopped = test::execute(console, "joint 2 15");
  CHECK_FALSE(stopped.done);
  CHECK_THAT(stopped.text, Contains("stopped as asked; joints"));
  CHECK_FALSE(test::execute(console, "joint 2 15").done);
  stop = false;
  CHECK(test::execute(console, "joint 2 15").done);
}

TEST_CASE("An exposure that the camera refuses is said and changes nothing") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  FailingCamera devices(cell);
  JogConsole console(read_calibrated_cell(cell), devices, "");
  const auto answer = test::execute(console, "exposure 1");
  CHECK_FALSE(answer.done);
  CHECK(answer.text == "the camera refuses an exposure of 1 us");
}

TEST_CASE("A typo, a wrong unit or a missing number moves nothing and says what is needed") {
  JogBench bench;
  bench.bend();
  CHECK_THAT(bench.refused("jiont 2 5"), Contains("no command 'jiont'"));
  CHECK_THAT(bench.refused("joint 2"), Contains("help says 'joint JOINT DEG"));
  CHECK_THAT(bench.refused("joint 2 5 deg"), Contains("help says 'joint JOINT DEG"));
  CHECK_THAT(bench.refused("joint 4 5"), Contains("allowed are 1, 2, 3"));
  CHECK_THAT(bench.refused("joint 0x1 5"), Contains("allowed are 1, 2, 3"));
  CHECK_THAT(bench.refused("joint 2 5deg"), Contains("'5deg'"));
  CHECK_THAT(bench.refused("x 1,5"), Contains("'1,5'; a finite number is needed"));
  CHECK_THAT(bench.refused("x nan"), Contains("a finite number is needed"));
  CHECK_THAT(bench.refused("y 10mm"), Contains("a finite number is needed"));
  CHECK(test::execute(bench.console, "").done);
}

TEST_CASE("Steps are bounded, whichever way they are asked for") {
  JogBench bench;
  bench.bend();
  CHECK_THAT(bench.refused("joint 1 15.1"), Contains("at most 15 deg at a time"));
  CHECK_THAT(bench.refused("joint 3 -90"), Contains("at most 15 deg at a time"));
  CHECK_THAT(bench.refused("x 51"), Contains("at most 50 mm at a time"));
  CHECK_THAT(bench.refused("y -1e9"), Contains("at most 50 mm at a time"));
}

TEST_CASE("Nothing moves before the drives are enabled") {
  JogBench bench;
  CHECK_THAT(bench.refused("joint 2 5"), Contains("enable them first"));
}

TEST_CASE("x and y move the end point by what was asked, joints turn their motors") {
  JogBench bench;
  bench.bend();
  const PlanarArm arm(bench.cell.arm.geometry);
  const Transmission transmission(bench.cell.transmission);
  const auto tip = [&] { return arm.forward(transmission.joints_from_pulses(bench.pulses())); };
  const TipPose start = tip();
  bench.done("x 10");
  bench.done("y -5");
  const Eigen::Vector2d moved_mm = (tip().p - start.p) / kMillimetre;
  CHECK((moved_mm - Eigen::Vector2d(10.0, -5.0)).norm() < kOnePulse_mm);
  CHECK(tip().phi == Approx(start.phi).margin(1e-4));
  const Pulses before = bench.pulses();
  bench.done("joint 1 1");
  CHECK(bench.pulses().tail<2>() == before.tail<2>());
  const double turned_deg =
      (bench.pulses()[0] - before[0]) / transmission.pulses_per_rad()[0] / kDegree;
  CHECK(turned_deg == Approx(1.0).margin(1e-3));
}

TEST_CASE("From outside the workspace only ways towards it are open, inside none leads out") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.arm.home = Joints::Zero();
  JogBench bench(cell);
  bench.done("enable");  // stretched out, 60 mm beyond the workspace
  bench.done("joint 2 15");
  CHECK_THAT(bench.refused("joint 2 -5"), Contains("workspace reaches from"));
  for (int i = 0; i < 3; ++i) bench.done("joint 2 15");
  CHECK_THAT(bench.refused("joint 2 -15"), Contains("workspace reaches from"));
}

TEST_CASE("The exposure can be set, and the meter follows it") {
  JogBench bench;
  bench.bend();
  CHECK_THAT(bench.done("look"), Contains("good"));
  CHECK_THAT(bench.done("exposure 2000"), Contains("2000 us") && Contains("expose more"));
  CHECK_THAT(bench.done("exposure 10000 12"), Contains("12.0 dB") && Contains("expose less"));
  CHECK_THAT(bench.refused("exposure 0"), Contains("positive"));
  CHECK_THAT(bench.refused("exposure 10ms"), Contains("'10ms'"));
  CHECK(bench.devices->camera().exposure().time_s == Approx(0.01));
}

TEST_CASE("Taught places become a table of targets, an id that is taken or none is refused") {
  JogBench bench;
  bench.bend();
  CHECK_THAT(bench.done("teach a"), Contains("as commanded"));
  bench.done("x -10");
  bench.done("teach b");
  const std::string table = read_file(bench.table);
  CHECK_THAT(bench.refused("teach a"), Contains("'a' is taken"));
  CHECK(read_file(bench.table) == table);
  bench.done("teach c,1");
  bench.done("teach #c");
  const auto targets = read_targets(bench.table);
  REQUIRE(targets.size() == 4);
  CHECK(targets[2].id == "c,1");
  CHECK(targets[3].id == "#c");
  CHECK((targets[0].p_d - targets[1].p_d - Eigen::Vector2d(0.01, 0.0)).norm() <
        kOnePulse_mm * kMillimetre);
}

TEST_CASE("A table is begun with the first place taught, also where an empty file is") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "new.csv", empty = folder.write("empty.csv", "");
  TaughtTargets begun(file), filled(empty);
  CHECK_FALSE(std::filesystem::exists(file));
  CHECK(std::filesystem::is_empty(empty));
  begun.append({"a", {0.1, 0.2}, 0.0});
  filled.append({"a", {0.1, 0.2}, 0.0});
  CHECK(read_targets(file).size() == 1);
  CHECK(read_file(empty) == read_file(file));
}

TEST_CASE("A table that could not be written or has no header is refused before anything moves") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(TaughtTargets(folder.path() / "absent" / "t.csv"), InputError,
                       Refused(Cause::kMissing, "absent/t.csv"));
  CHECK_THROWS_MATCHES(TaughtTargets(folder.write("t.csv", "# places\n")), InputError,
                       Refused(Cause::kMissing, "t.csv"));
}

TEST_CASE("Where the arm stands is told without a negative zero") {
  CHECK_THAT(JogBench().done("where"),
             Contains("phi 0.000 deg"));  // the nearest pulses lie just below 0
}

TEST_CASE("A table is continued only when its ids are known and its last line is whole") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("t.csv", "id,x_mm,y_mm,phi_deg\na,1,2,\n");
  TaughtTargets taught(file);
  CHECK_THROWS_MATCHES(taught.append({"a", {0.0, 0.0}, 0.0}), InputError,
                       Refused(Cause::kExists, "'a'"));
  taught.append({"b", {0.1, 0.2}, 0.0});
  CHECK(read_targets(file).size() == 2);
  CHECK_THROWS_MATCHES(TaughtTargets(folder.write("u.csv", "id,x_mm,y_mm,z_mm\na,1,2,3\n")),
                       InputError, Refused(Cause::kInvalid, "u.csv:1"));
  CHECK_THROWS_MATCHES(TaughtTargets(folder.write("v.csv", "id,x_mm,y_mm,phi_deg\na,1,2,0")),
                       InputError, Refused(Cause::kInvalid, "v.csv"));
  CHECK_THROWS_MATCHES(TaughtTargets(folder.write("w.csv", "id,x_mm,y_mm,phi_deg\na,one,2,0\n")),
                       InputError, Refused(Cause::kInvalid, "w.csv:2: x_mm"));
}

TEST_CASE("Places are taught to a table without directions, without theirs") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("t.csv", "# mine\nid,x_mm,y_mm\n\na,1,2\n");
  TaughtTargets taught(file);
  taught.append({"b", {0.1, 0.2}, 0.5});
  CHECK(read_file(file) == "# mine\nid,x_mm,y_mm\n\na,1,2\nb,100.000000,200.000000\n");
  CHECK(read_targets(file).size() == 2);
  CHECK_FALSE(taught.at("b").phi_d);
}

TEST_CASE("A step along the line of one that was stopped returns to that line") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const auto devices = open_cell(cell);
  double stop_s = HUGE_VAL;
  JogConsole console(read_calibrated_cell(cell), *devices, "",
                     [&] { return devices->clock().now_s() > stop_s; });
  REQUIRE(test::execute(console, "enable").done);
  for (int i = 0; i < 2; ++i) REQUIRE(test::execute(console, "joint 2 15").done);
  const Eigen::Vector2d begin = console.arm().tip().p;
  stop_s = devices->clock().now_s() + 0.1;
  const auto cut = test::execute(console, "x -40");
  CHECK_FALSE(cut.done);
  CHECK_THAT(cut.text, Contains(" of 40.000 mm; joints"));
  const Eigen::Vector2d rest = console.arm().tip().p;
  REQUIRE(std::abs(rest.y() - begin.y()) > 0.05e-3);  // no motor has made the same share
  stop_s = HUGE_VAL;
  CHECK(test::execute(console, "x -5").done);
  CHECK(std::abs(console.arm().tip().p.y() - begin.y()) < 5e-6);
  CHECK(console.arm().tip().p.x() == Approx(rest.x() - 5e-3).margin(5e-6));
}

TEST_CASE("The meter tells dark, good and saturated lamps apart, whatever a few hot pixels say") {
  const auto picture = [](int level, int white_rows) {
    cv::Mat image(200, 200, CV_8UC1, cv::Scalar(10));
    image(cv::Rect(50, 50, 40, 40)).setTo(level);
    image(cv::Rect(50, 50, 40, white_rows)).setTo(255);
    image.at<unsigned char>(150, 150) = 255;
    return image;
  };
  const ExposureReading dark = read_exposure(picture(60, 0));
  CHECK(dark.peak_level == 60);
  CHECK(dark.too_dark());
  CHECK_THAT(dark.text(), Contains("expose more"));
  const ExposureReading good = read_exposure(picture(200, 0));
  CHECK_FALSE((good.too_dark() || good.too_bright()));
  const ExposureReading bright = read_exposure(picture(240, 10));
  CHECK(bright.saturated_share == Approx(0.25).margin(1e-3));
  CHECK_THAT(bright.text(), Contains("expose less"));
}

}  // namespace
}  // namespace planar
