#include "planar_servo/hardware/robot/visp_robot.h"

#include <visp3/robot/vpRobotException.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "planar_servo/base/core/units.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "planar_servo/hardware/robot/homing.h"
#include "support/finite_differences.h"
#include "support/refused.h"
#include "support/robot_bench.h"

namespace planar {
namespace {

using test::Bench;
using test::column;
using test::ReadyBench;
using test::Refused;
using test::transmission_settings;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kFiniteDifference = 1e-9;  // fourth order with a step of 1e-3
const Joints kSomewhere{0.3, 1.5, -0.4};

/// A machine that searches a home switch until it is stopped.
struct SearchingMachine final : MachineLink {
  void switch_on() override { state.on = true; }
  void go_to(const Pulses&, const std::array<DriveLimits, 3>&) override {}
  void stop() override { state.moving = state.homing = false; }
  void search_home(int, HomeDirection) override { state.moving = state.homing = true; }
  MachineState read() override { return state; }
  const char* starter() const override { return ""; }
  MachineState state;
};

}  // namespace

TEST_CASE("A move sends each drive the absolute rounded pulses and waits for all of them") {
  ReadyBench bench;
  bench.robot.move_to(kSomewhere);
  const double pulses_per_rad = 1e6 / (2.0 * kPi);
  CHECK(bench.drives[0].targets ==
        std::vector<std::int32_t>{static_cast<int>(std::lround(0.3 * pulses_per_rad))});
  CHECK(bench.drives[1].targets ==
        std::vector<std::int32_t>{static_cast<int>(std::lround(-1.2 * pulses_per_rad))});
  CHECK(bench.drives[2].targets ==
        std::vector<std::int32_t>{static_cast<int>(std::lround(-1.9 * pulses_per_rad / 2))});
  for (auto& drive : bench.drives) CHECK_FALSE(drive.status().moving);
  CHECK(bench.clock.now_s() > 1.195);  // motor 2 turns 1.2 rad at 1 rad/s; polled every 5 ms
  CHECK((bench.robot.commanded_joints() - kSomewhere).cwiseAbs().maxCoeff() <
        2.0 * test::kPulse_rad);
}

TEST_CASE("Repeating the commanded joints sends the same pulses: no remainder is carried") {
  ReadyBench bench;
  bench.robot.move_to(kSomewhere);
  const Pulses first = bench.robot.commanded_pulses();
  for (int i = 0; i < 5; ++i) bench.robot.move_to(bench.robot.commanded_joints());
  CHECK(bench.robot.commanded_pulses() == first);
}

TEST_CASE("The drives get their speeds and accelerations in pulses") {
  ReadyBench bench;
  CHECK(bench.drives[1].max_speed_pulses_s == Approx(1e6 / (2.0 * kPi)));
  CHECK(bench.drives[1].max_acceleration_pulses_s2 == Approx(5e6 / (2.0 * kPi)));
}

TEST_CASE("Nothing moves when one motor would leave its limits") {
  ReadyBench bench;
  CHECK_THROWS_MATCHES(bench.robot.move_to({0.0, 2.9, 2.9}), WorkError,
                       Refused(Cause::kUnreachable, "motor 2"));
  CHECK(bench.nothing_was_sent());
}

TEST_CASE("Nothing moves when an angle is not finite") {
  ReadyBench bench;
  CHECK_THROWS_AS(bench.robot.move_to({0.0, 0.1, kNan}), std::invalid_argument);
  CHECK(bench.nothing_was_sent());
}

TEST_CASE("Nothing moves while a drive is off, faulty or lost") {
  Bench off;
  CHECK_THROWS_MATCHES(off.robot.move_to(kSomewhere), DriveError,
                       Refused(Cause::kDevice, "drive 1"));
  CHECK(off.nothing_was_sent());
  ReadyBench faulty;
  faulty.drives[2].fault = "low supply voltage";
  CHECK_THROWS_MATCHES(faulty.robot.move_to(kSomewhere), DriveError,
                       Refused(Cause::kDevice, "drive 3"));
  CHECK(faulty.nothing_was_sent());
  ReadyBench lost;
  lost.drives[1].knows_position = false;
  CHECK_THROWS_MATCHES(lost.robot.move_to(kSomewhere), DriveError,
                       Refused(Cause::kDevice, "drive 2"));
  CHECK(lost.nothing_was_sent());
}

TEST_CASE("What a drive counts from nowhere is no joint angle, until it is taught") {
  ReadyBench bench;
  bench.robot.move_to(kSomewhere);
  REQUIRE(bench.robot.known_joints());
  bench.drives[1].knows_position = false;
  bench.robot.read_drives();
  CHECK_FALSE(bench.robot.known_joints());
  CHECK_FALSE(bench.robot.known_pulses());
  CHECK_THROWS_MATCHES(bench.robot.commanded_joints(), DriveError,
                       Refused(Cause::kDevice, "drive 2"));
  CHECK_THROWS_AS(bench.robot.present_joints(), DriveError);
  bench.robot.teach_home(1);
  CHECK(bench.robot.known_pulses() == bench.robot.commanded_pulses());
}

TEST_CASE("A position that was forgotten is no other user's of these drives either") {
  ReadyBench bench;
  bench.robot.move_to(kSomewhere);
  bench.robot.forget_position();
  for (const test::MockPulseDrive& drive : bench.drives) CHECK_FALSE(drive.knows_position);
}

TEST_CASE("A drive that fails on its way halts all and is named") {
  ReadyBench bench;
  bench.drives[1].fault_on_the_way = "driver error";
  CHECK_THROWS_AS(bench.robot.move_to(kSomewhere), WorkError);
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
  ReadyBench again;
  again.drives[1].fault_on_the_way = "driver error";
  CHECK_THROWS_MATCHES(again.robot.move_to(kSomewhere), DriveError,
                       Refused(Cause::kDevice, "drive 2"));
}

TEST_CASE("A drive that loses its position on its way halts all and is named") {
  ReadyBench bench;
  const auto lose = [&]() -> std::optional<std::string> {
    if (bench.clock.now_s() > 0.1) bench.drives[2].knows_position = false;
    return std::nullopt;
  };
  CHECK_THROWS_MATCHES(bench.robot.move_to(kSomewhere, lose), DriveError,
                       Refused(Cause::kDevice, "drive 3"));
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
  CHECK_FALSE(bench.robot.known_pulses());
}

TEST_CASE("An arm whose guard objects slows down to rest and keeps its positions") {
  ReadyBench bench;
  const auto objection = bench.robot.move_to(kSomewhere, [&]() -> std::optional<std::string> {
    if (bench.clock.now_s() < 0.1) return std::nullopt;
    return "the camera is blind";
  });
  CHECK(objection == std::string("the camera is blind"));
  for (int i = 0; i < 3; ++i) {
    const auto& drive = bench.drives[static_cast<std::size_t>(i)];
    CAPTURE(i);
    CHECK(drive.halts == 0);
    REQUIRE(drive.targets.size() == 2);
    // It had turned for 0.1 s at its speed v and stops v^2/(2a) further on: 0.1 s more of it. The
    // poll that notices may be 10 ms late.
    const double per_s = drive.max_speed_pulses_s;
    CHECK(std::abs(drive.targets[1]) == Approx(0.2 * per_s).margin(0.01 * per_s));
    CHECK(drive.targets[0] * static_cast<double>(drive.targets[1]) > 0.0);
    CHECK(bench.robot.commanded_pulses()[i] == drive.targets[1]);
  }
}

TEST_CASE("An arm whose guard objects from the start does not move") {
  ReadyBench bench;
  const auto objection =
      bench.robot.move_to(kSomewhere, [] { return std::optional<std::string>("no"); });
  CHECK(objection == std::string("no"));
  CHECK(bench.nothing_was_sent());
}

TEST_CASE("A drive that refuses its target halts those already started") {
  ReadyBench bench;
  bench.drives[2].refuses_targets = true;
  CHECK_THROWS_MATCHES(bench.robot.move_to(kSomewhere), WorkError,
                       Refused(Cause::kDevice, "mock drive"));
  CHECK(bench.drives[0].halts == 1);
  CHECK_FALSE(bench.drives[0].status().moving);
  CHECK(bench.robot.commanded_pulses()[0] == bench.drives[0].status().position_pulses);
}

TEST_CASE("A drive that never arrives times out and halts all") {
  ReadyBench bench;
  bench.drives[0].stalls = true;
  CHECK_THROWS_MATCHES(bench.robot.move_to(kSomewhere), DriveError,
                       Refused(Cause::kDevice, "arrived"));
  CHECK(bench.drives[2].halts == 1);
  CHECK(bench.clock.now_s() < 10.0);  // the move itself takes 1.4 s
}

TEST_CASE("Energizing names the drive that reports a fault") {
  Bench bench;
  bench.drives[1].fault = "kill switch";
  CHECK_THROWS_MATCHES(bench.robot.energize(), DriveError, Refused(Cause::kDevice, "drive 2"));
}

TEST_CASE("A motor counts from its home switch once it has found it") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[1].home = HomeReference::kForwardSwitch;
  settings.drives[1].home_rad = -2.0;
  ReadyBench bench(settings);
  bench.drives[1].knows_position = false;
  CHECK(bench.robot.unhomed() == std::vector<int>{1});
  bench.robot.search_home(1);
  CHECK(bench.robot.unhomed().empty());
  CHECK(bench.drives[1].targets == std::vector<std::int32_t>{test::MockPulseDrive::kSwitch_pulses});
  CHECK(bench.robot.commanded_pulses()[1] == std::lround(2.0 * 1e6 / (2.0 * kPi)));
  CHECK(bench.drives[0].targets.empty());
}

TEST_CASE("A motor without a home switch counts from the mark that it is taught") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[0].home_rad = 0.5;
  ReadyBench bench(settings);
  bench.drives[0].knows_position = false;
  CHECK_THROWS_MATCHES(bench.robot.search_home(0), DriveError,
                       Refused(Cause::kMissing, "28.648 deg"));
  CHECK(bench.nothing_was_sent());
  bench.robot.teach_home(0);
  CHECK(bench.robot.unhomed().empty());
  CHECK(bench.robot.commanded_pulses()[0] == std::lround(0.5 * 1e6 / (2.0 * kPi)));
}

TEST_CASE("Drives that lost their position are homed only when somebody allows it") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[1].home = HomeReference::kForwardSwitch;
  ReadyBench bench(settings);
  bench.drives[1].knows_position = false;
  CHECK_THROWS_MATCHES(home_where_needed(bench.robot, {}, "; go on"), DriveError,
                       Refused(Cause::kDevice, ": 2; start with --home"));
  CHECK_THROWS_MATCHES(home_where_needed(bench.robot, {}, "; go on"), DriveError,
                       Refused(Cause::kDevice, "; go on"));
  std::string asked;
  const auto answer = [&](bool allowed) {
    return [&asked, allowed](Homing way, const std::string& unhomed) {
      CHECK(way == Homing::kSearch);
      asked = unhomed;
      return allowed;
    };
  };
  CHECK_THROWS_AS(home_where_needed(bench.robot, answer(false)), DriveError);
  CHECK(bench.robot.unhomed() == std::vector<int>{1});
  home_where_needed(bench.robot, answer(true));
  CHECK(bench.robot.unhomed().empty());
  CHECK(asked == "drives that have lost their position: 2");
  asked.clear();
  home_where_needed(bench.robot, answer(false));
  CHECK(asked.empty());
}

TEST_CASE("A drive without a home switch counts from its mark once somebody says it is there") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[0].home_rad = 0.5;
  settings.drives[1].home = HomeReference::kForwardSwitch;
  ReadyBench bench(settings);
  bench.drives[0].knows_position = bench.drives[1].knows_position = false;
  std::vector<std::string> asked;
  const auto answer = [&](bool at_mark) {
    return [&asked, at_mark](Homing way, const std::string& unhomed) {
      asked.push_back(unhomed);
      return way == Homing::kSearch || at_mark;
    };
  };
  CHECK_THROWS_MATCHES(home_where_needed(bench.robot, answer(false)), DriveError,
                       Refused(Cause::kDevice, "--at-marks"));
  CHECK_THAT(asked.at(0), Catch::Contains("1 (mark at 28.648 deg)"));
  CHECK(bench.nothing_was_sent());
  home_where_needed(bench.robot, answer(true));
  CHECK(asked.size() == 3);
  CHECK(bench.robot.unhomed().empty());
  CHECK(bench.robot.commanded_pulses()[0] == std::lround(0.5 * 1e6 / (2.0 * kPi)));
}

TEST_CASE("A search that fails on its way halts all and leaves the motor unhomed") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[1].home = HomeReference::kReverseSwitch;
  ReadyBench bench(settings);
  bench.drives[1].fault_on_the_way = "kill switch";
  CHECK_THROWS_AS(bench.robot.search_home(1), DriveError);
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
  CHECK(bench.robot.unhomed() == std::vector<int>{1});
}

TEST_CASE("An arm that is stopped on its way slows down to rest and keeps its position") {
  ReadyBench bench;
  const double begin_s = bench.clock.now_s();
  bool stop = true;
  bench.robot.stop_when([&] { return stop && bench.clock.now_s() > begin_s + 0.1; });
  CHECK_THROWS_AS(bench.robot.move_to({0.5, 0.5, 0.5}), StopRequested);
  const Pulses rest = bench.robot.commanded_pulses();
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(bench.drives[i].halts == 0);
    CHECK(bench.drives[i].targets.size() == 2);
    CHECK(bench.drives[i].status().position_pulses == rest[static_cast<int>(i)]);
  }
  CHECK_THROWS_AS(bench.robot.move_to({0.5, 0.5, 0.5}), StopRequested);
  CHECK(bench.drives[0].targets.size() == 2);
  stop = false;
  CHECK_FALSE(bench.robot.move_to({0.5, 0.5, 0.5}));
}

TEST_CASE("A search that is stopped halts all and leaves the motor unhomed") {
  TransmissionSettings settings = transmission_settings();
  settings.drives[1].home = HomeReference::kReverseSwitch;
  ReadyBench bench(settings);
  const double begin_s = bench.clock.now_s();
  bench.robot.stop_when([&] { return bench.clock.now_s() > begin_s + 0.1; });
  CHECK_THROWS_AS(bench.robot.search_home(1), StopRequested);
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
  CHECK(bench.robot.unhomed() == std::vector<int>{1});
}

TEST_CASE("A machine's search that is stopped or given up leaves the motor unhomed") {
  const double stop_s = GENERATE(0.1, 1e9);
  TransmissionSettings settings = transmission_settings();
  settings.drives[1].home = HomeReference::kReverseSwitch;
  const Transmission transmission(settings);
  test::ManualClock clock;
  LinkedDrives drives("the machine", transmission.rated_limits(),
                      [] { return std::make_unique<SearchingMachine>(); });
  PlanarRobot robot(PlanarArm({{0.3, 0.25}, Rotation::kClockwise}), transmission, drives, clock);
  robot.energize();
  for (const int joint : {0, 2}) robot.teach_home(joint);
  robot.stop_when([&] { return clock.now_s() > stop_s; });
  CHECK_THROWS_AS(robot.search_home(1), WorkError);
  CHECK_FALSE(drives.status()[1].moving);
  CHECK(robot.unhomed() == std::vector<int>{1});
}

TEST_CASE("Recovery waits until the fault is gone, and gives up after its patience") {
  ReadyBench bench;
  bench.drives[2].fault = "low supply voltage";
  CHECK_THROWS_MATCHES(bench.robot.recover(3.0), DriveError, Refused(Cause::kDevice, "drive 3"));
  CHECK(bench.clock.now_s() <= 3.0);
  bench.drives[2].fault.clear();
  bench.robot.recover(3.0);
  CHECK_NOTHROW(bench.robot.move_to(kSomewhere));
}

TEST_CASE("A stop ends the wait for a lost drive at once") {
  ReadyBench bench;
  bench.drives[2].fault = "low supply voltage";
  bench.robot.stop_when([&] { return bench.clock.now_s() > 0.35; });  // in the pause of 0.4 s
  CHECK_THROWS_AS(bench.robot.recover(3.0), StopRequested);
  CHECK(bench.clock.now_s() < 0.37);
}

TEST_CASE("A stop by hand lasts until a person switches the arm on, even if it is gone before") {
  ReadyBench bench;
  bench.drives[0].fault_on_the_way = "its link is down";
  bench.drives[2].fault_on_the_way = "kill switch";
  bench.drives[2].by_hand = true;
  CHECK_THROWS_MATCHES(bench.robot.move_to(kSomewhere), StoppedByHand,
                       Refused(Cause::kStopped, "its link is down; drive 3"));
  for (auto& drive : bench.drives) drive.fault_on_the_way.clear();
  CHECK_THROWS_AS(bench.robot.energize(), StoppedByHand);
  CHECK_THROWS_AS(bench.robot.recover(3.0), StoppedByHand);
  bench.robot.switch_on();
  CHECK_NOTHROW(bench.robot.energize());
}

TEST_CASE("Destruction halts the drives when one still moves, and leaves resting ones alone") {
  test::ManualClock clock;
  std::array<test::MockPulseDrive, 3> drives{
      test::MockPulseDrive(clock), test::MockPulseDrive(clock), test::MockPulseDrive(clock)};
  SeparateDrives group({&drives[0], &drives[1], &drives[2]});
  {
    PlanarRobot robot(PlanarArm({{0.3, 0.25}, Rotation::kClockwise}),
                      Transmission(transmission_settings()), group, clock);
    robot.energize();
  }
  CHECK(drives[1].halts == 0);
  {
    PlanarRobot robot(PlanarArm({{0.3, 0.25}, Rotation::kClockwise}),
                      Transmission(transmission_settings()), group, clock);
    drives[1].set_target(100000);
  }
  CHECK(drives[1].halts == 1);
}

TEST_CASE("As a vpRobot it moves joints and poses, in position control only") {
  ReadyBench bench;
  const PlanarRobot& robot = bench.robot;
  VispRobot visp(bench.robot);
  CHECK_THROWS_AS(visp.setPosition(vpRobot::JOINT_STATE, column({0.3, 1.5, -0.4})),
                  vpRobotException);
  CHECK(bench.nothing_was_sent());
  visp.setRobotState(vpRobot::STATE_POSITION_CONTROL);
  visp.setPosition(vpRobot::JOINT_STATE, column({0.3, 1.5, -0.4}));
  CHECK(visp.getPosition(vpRobot::JOINT_STATE)[1] == Approx(1.5).margin(test::kPulse_rad));

  const TipPose tip = robot.arm().forward({0.1, 1.6, 0.2});
  visp.setPosition(vpRobot::REFERENCE_FRAME, column({tip.p.x(), tip.p.y(), 0, 0, 0, tip.phi}));
  CHECK((robot.commanded_joints() - Joints(0.1, 1.6, 0.2)).norm() < 3.0 * test::kPulse_rad);
  const vpColVector pose = visp.getPosition(vpRobot::REFERENCE_FRAME);
  CHECK(pose[0] == Approx(tip.p.x()).margin(test::kPulse_rad));
  CHECK(pose[5] == Approx(tip.phi).margin(3.0 * test::kPulse_rad));

  CHECK_THROWS_WITH(visp.setPosition(vpRobot::REFERENCE_FRAME, column({0.9, 0, 0, 0, 0, 0})),
                    Catch::Contains("both links together"));
  CHECK_THROWS_AS(visp.setPosition(vpRobot::REFERENCE_FRAME, column({0.3, 0, 0.1, 0, 0, 0})),
                  vpRobotException);
  CHECK_THROWS_AS(visp.setPosition(vpRobot::END_EFFECTOR_FRAME, pose), vpRobotException);
}

TEST_CASE("As a vpRobot its state stop halts the drives") {
  ReadyBench bench;
  VispRobot(bench.robot).setRobotState(vpRobot::STATE_STOP);
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
}

TEST_CASE("The vpRobot Jacobians are those of the pose, in the base and in the tool's frame") {
  ReadyBench bench;
  bench.robot.move_to(kSomewhere);
  const Joints theta = bench.robot.commanded_joints();
  const auto pose = [&](const Eigen::VectorXd& angles) -> Eigen::VectorXd {
    const TipPose tip = bench.robot.arm().forward(Joints(angles));
    return Eigen::Vector3d(tip.p.x(), tip.p.y(), tip.phi);
  };
  const auto planar_rows = [](const vpMatrix& J) {
    Eigen::Matrix3d rows;
    for (int i = 0; i < 3; ++i)
      rows.row(i) << J[i == 2 ? 5 : i][0], J[i == 2 ? 5 : i][1], J[i == 2 ? 5 : i][2];
    return rows;
  };
  VispRobot visp(bench.robot);
  vpMatrix base;
  visp.get_fJe(base);
  CHECK(base.getRows() == 6);
  CHECK(test::jacobian_mismatch(planar_rows(base), pose, theta, 1e-3) < kFiniteDifference);
  vpMatrix tool;
  visp.get_eJe(tool);
  Eigen::Matrix3d base_from_tool = Eigen::Matrix3d::Identity();
  base_from_tool.topLeftCorner<2, 2>() = rotation2d(bench.robot.arm().forward(theta).phi);
  CHECK((base_from_tool * planar_rows(tool)).isApprox(planar_rows(base)));
}

}  // namespace planar
