#include <visp3/robot/vpRobotException.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/hardware/robot/visp_robot.h"
#include "support/refused.h"
#include "support/robot_bench.h"

namespace planar {
namespace {

using test::column;
using test::Refused;

constexpr double kCall_s = 0.02;
/// One call's step in joints is straight: over a way w from call to call the end point falls short
/// of its line by about w^2 / (2 L), here 1 mm and 0.25 m: 2 um in each of 100 calls.
constexpr double kStraight_m = 0.25e-3;

/// Under velocity control, at rest with the links at a right angle.
struct TurningBench : test::ReadyBench {
  VispRobot visp{robot};

  TurningBench() {
    robot.move_to({0.3, 0.3 + kPi / 2.0, -0.4});
    visp.setRobotState(vpRobot::STATE_VELOCITY_CONTROL);
  }

  void command(vpRobot::vpControlFrameType frame, const vpColVector& velocity) {
    visp.setVelocity(frame, velocity);
    clock.sleep_for_s(kCall_s);
  }

  TipPose tip() {
    const vpColVector pose = visp.getPosition(vpRobot::REFERENCE_FRAME);
    return {{pose[0], pose[1]}, pose[5]};
  }

  Eigen::Vector3d motors_rad() {
    Pulses pulses;
    for (int i = 0; i < 3; ++i)
      pulses[i] = drives[static_cast<std::size_t>(i)].status().position_pulses;
    return pulses.cast<double>().cwiseQuotient(robot.transmission().pulses_per_rad());
  }

  bool rests() {
    for (auto& drive : drives)
      if (drive.status().moving) return false;
    return true;
  }

  int halts() const { return drives[0].halts + drives[1].halts + drives[2].halts; }
};

struct DrivesFromRestToRest final : ForwardingDrives {
  using ForwardingDrives::ForwardingDrives;
  std::optional<std::string> stream_refusal() const override { return "they brake to rest first"; }
};

/// As a drive says that turns; one that has arrived rests.
std::array<DriveStatus, 3> turning(const std::array<std::int32_t, 3>& positions,
                                   const std::array<std::int32_t, 3>& targets) {
  std::array<DriveStatus, 3> status;
  for (std::size_t i = 0; i < 3; ++i) {
    status[i].position_pulses = positions[i];
    status[i].target_pulses = targets[i];
    status[i].moving = positions[i] != targets[i];
  }
  return status;
}

/// Told so long ago that the motors have the velocities by now.
VelocityMove long_ago(const Eigen::Vector3d& velocity) {
  VelocityMove move;
  move.from = move.velocity = velocity;
  return move;
}

std::array<DriveLimits, 3> rated_limits() {
  return {DriveLimits{1e5, 5e5}, DriveLimits{2e5, 4e5}, DriveLimits{5e4, 5e5}};
}

}  // namespace

TEST_CASE("A twist of the base frame moves the end point on a straight line at its speed") {
  for (const double direction : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    CAPTURE(direction);
    TurningBench bench;
    const TipPose start = bench.tip();
    const Eigen::Vector2d along(std::cos(direction), std::sin(direction));
    const Eigen::Vector2d v = 0.05 * along;
    for (int call = 1; call <= 100; ++call) {
      bench.command(vpRobot::REFERENCE_FRAME, column({v.x(), v.y(), 0, 0, 0, 0.1}));
      const Eigen::Vector2d way = bench.tip().p - start.p;
      const double expected = 0.05 * kCall_s * call;
      CHECK(std::abs(along.x() * way.y() - along.y() * way.x()) < kStraight_m);
      CHECK(along.dot(way) == Approx(expected).epsilon(0.01));
    }
    CHECK(wrap_angle(bench.tip().phi - start.phi) == Approx(0.2).margin(1e-3));
  }
}

TEST_CASE("Joints turn at the velocities asked for") {
  TurningBench bench;
  const vpColVector start = bench.visp.getPosition(vpRobot::JOINT_STATE);
  for (int call = 0; call < 50; ++call)
    bench.command(vpRobot::JOINT_STATE, column({0.1, -0.2, 0.3}));
  const vpColVector turned = bench.visp.getPosition(vpRobot::JOINT_STATE) - start;
  CHECK(turned[0] == Approx(0.1).margin(50.0 * test::kPulse_rad));
  CHECK(turned[1] == Approx(-0.2).margin(50.0 * test::kPulse_rad));
  CHECK(turned[2] == Approx(0.3).margin(50.0 * test::kPulse_rad));
  CHECK_THROWS_MATCHES(bench.robot.move_to({0.3, 1.5, -0.4}), WorkError,
                       Refused(Cause::kInvalid, "velocity control"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(bench.robot.turn([&](const Joints&) { return Joints(0.1, nan, 0.0); }),
                    Catch::Contains("must be finite"));
  bench.robot.end_turning();
  CHECK_NOTHROW(bench.robot.move_to({0.3, 1.5, -0.4}));
}

TEST_CASE("Whatever velocities are asked for, no drive leaves its limits") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> velocity(-3.0, 3.0);
  TurningBench bench;
  bench.visp.setMaxRotationVelocity(10.0);
  bench.visp.setMaxTranslationVelocity(10.0);
  const auto rated = bench.settings;
  int refused = 0;
  for (int call = 0; call < 2000; ++call) {
    const bool joints = call % 400 < 200;
    const double a = velocity(random), b = velocity(random), c = velocity(random);
    try {
      for (int repeat = 0; repeat < 10; ++repeat) {
        bench.command(joints ? vpRobot::JOINT_STATE : vpRobot::REFERENCE_FRAME,
                      joints ? column({a, b, c}) : column({a, b, 0, 0, 0, c}));
        const Eigen::Vector3d motors = bench.motors_rad();
        for (int i = 0; i < 3; ++i) {
          const auto& drive = bench.drives[static_cast<std::size_t>(i)];
          const auto& motor = rated.drives[static_cast<std::size_t>(i)];
          const double scale = std::abs(bench.robot.transmission().pulses_per_rad()[i]);
          const auto& limits = rated.limits_rad[static_cast<std::size_t>(i)];
          REQUIRE(drive.max_speed_pulses_s <= scale * motor.max_speed_rad_s * (1.0 + 1e-12));
          REQUIRE(drive.max_acceleration_pulses_s2 <=
                  scale * motor.max_acceleration_rad_s2 * (1.0 + 1e-12));
          REQUIRE(motors[i] >= limits[0]);
          REQUIRE(motors[i] <= limits[1]);
        }
      }
    } catch (const WorkError&) {
      ++refused;
    } catch (const vpRobotException&) {
      ++refused;
    }
  }
  CHECK(refused > 0);
  CHECK(refused < 2000);
  CHECK(bench.halts() == 0);
}

TEST_CASE("A velocity beyond what the motors can do is scaled as a whole") {
  TurningBench bench;
  bench.visp.setMaxRotationVelocity(100.0);
  bench.visp.setVelocity(vpRobot::JOINT_STATE, column({4.0, 0.0, 2.0}));
  // Motor 1 can turn at 1 rad/s; motors 2 and 3 turn by the differences of -4 and 2.
  const double pulses_per_rad = 1e6 / (2.0 * kPi);
  CHECK(bench.drives[0].max_speed_pulses_s == Approx(pulses_per_rad));
  CHECK(bench.drives[1].max_speed_pulses_s == Approx(pulses_per_rad));
  CHECK(bench.drives[2].max_speed_pulses_s == Approx(0.25 * pulses_per_rad));
}

TEST_CASE("ViSP's greatest velocities bound the tool and the joints") {
  TurningBench bench;
  bench.visp.setMaxTranslationVelocity(0.01);
  const TipPose start = bench.tip();
  for (int call = 0; call < 50; ++call)
    bench.command(vpRobot::REFERENCE_FRAME, column({0.3, 0.4, 0, 0, 0, 0}));
  const Eigen::Vector2d way = bench.tip().p - start.p;
  CHECK(way.y() == Approx(0.01).epsilon(0.01));  // of the larger component, for a second
  CHECK(way.x() == Approx(0.0075).epsilon(0.01));
}

TEST_CASE("An arm whose caller goes silent holds its velocity for a while and comes to rest") {
  TurningBench bench;
  for (int call = 0; call < 5; ++call) bench.command(vpRobot::JOINT_STATE, column({0.5, 0.5, 0.5}));
  const double said_s = bench.clock.now_s() - kCall_s;
  const double there = bench.visp.getPosition(vpRobot::JOINT_STATE)[0] - 0.5 * kCall_s;
  while (bench.clock.now_s() < said_s + PlanarRobot::kVelocityHold_s) {
    CHECK_FALSE(bench.rests());
    bench.clock.sleep_for_s(kCall_s);
  }
  bench.clock.sleep_for_s(2.0 * 0.5 / 5.0);  // twice the time in which motor 1 brakes
  CHECK(bench.rests());
  const double braking_rad = 0.5 * 0.5 / (2.0 * 5.0);
  CHECK(bench.visp.getPosition(vpRobot::JOINT_STATE)[0] - there ==
        Approx(0.5 * PlanarRobot::kVelocityHold_s + braking_rad).margin(10.0 * test::kPulse_rad));
  CHECK(bench.halts() == 0);
  CHECK_NOTHROW(bench.visp.setVelocity(vpRobot::JOINT_STATE, column({-0.5, -0.5, -0.5})));
}

TEST_CASE("A velocity of zero and the end of velocity control bring the arm to rest unharmed") {
  TurningBench bench;
  const bool by_state = GENERATE(false, true);
  for (int call = 0; call < 5; ++call)
    bench.command(vpRobot::REFERENCE_FRAME, column({0.05, 0.0, 0, 0, 0, 0.2}));
  const TipPose told = bench.tip();
  if (by_state) {
    bench.visp.setRobotState(vpRobot::STATE_STOP);
  } else {
    bench.visp.setVelocity(vpRobot::REFERENCE_FRAME, column({0, 0, 0, 0, 0, 0}));
    bench.clock.sleep_for_s(0.2);
  }
  CHECK(bench.rests());
  CHECK(bench.halts() == 0);
  CHECK((bench.tip().p - told.p).norm() < 2e-3);
  bench.visp.setRobotState(vpRobot::STATE_POSITION_CONTROL);
  CHECK(bench.drives[1].max_speed_pulses_s == Approx(1e6 / (2.0 * kPi)));
  bench.visp.setPosition(vpRobot::JOINT_STATE, column({0.3, 1.5, -0.4}));
  CHECK(bench.robot.commanded_joints()[1] == Approx(1.5).margin(test::kPulse_rad));
}

TEST_CASE("An arm under velocity control that is stopped as asked rests and says so") {
  TurningBench bench;
  bool stop = false;
  bench.robot.stop_when([&] { return stop; });
  for (int call = 0; call < 5; ++call) bench.command(vpRobot::JOINT_STATE, column({0.5, 0.5, 0.5}));
  stop = true;
  CHECK_THROWS_AS(bench.visp.setVelocity(vpRobot::JOINT_STATE, column({0.5, 0.5, 0.5})),
                  StopRequested);
  CHECK(bench.rests());
  CHECK(bench.halts() == 0);
}

TEST_CASE(
    "A velocity that would lead beyond a motor's limits is refused, and the arm rests before") {
  TurningBench bench;
  const auto turn_on = [&] {
    for (int call = 0; call < 1000; ++call)
      bench.command(vpRobot::JOINT_STATE, column({0.3, 0.3, 0.3}));
  };
  CHECK_THROWS_MATCHES(turn_on(), WorkError, Refused(Cause::kUnreachable, "motor 1"));
  bench.clock.sleep_for_s(1.0);
  CHECK(bench.rests());
  CHECK(bench.motors_rad()[0] < 3.0);
  CHECK(bench.motors_rad()[0] > 3.0 - 0.3 * (PlanarRobot::kVelocityHold_s + 0.1));
  CHECK_NOTHROW(bench.visp.setVelocity(vpRobot::JOINT_STATE, column({-0.3, -0.3, -0.3})));
}

TEST_CASE("What a planar arm cannot do is refused before anything moves") {
  TurningBench bench;
  VispRobot& visp = bench.visp;
  const auto sent = bench.drives[0].targets.size();
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::REFERENCE_FRAME, column({0, 0, 0.01, 0, 0, 0})),
                    Catch::Contains("vz, wx and wy have to be 0"));
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::REFERENCE_FRAME, column({0, 0, 0, 0, 0.1, 0})),
                    Catch::Contains("vz, wx and wy have to be 0"));
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::REFERENCE_FRAME, column({0.1, 0, 0})),
                    Catch::Contains("6 elements"));
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::JOINT_STATE, column({0.1, 0})),
                    Catch::Contains("3 elements"));
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::CAMERA_FRAME, column({0.1, 0, 0})),
                    Catch::Contains("JOINT_STATE and REFERENCE_FRAME only"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::JOINT_STATE, column({0.1, nan, 0})),
                    Catch::Contains("element 1 of the velocity is not finite"));
  CHECK(bench.drives[0].targets.size() == sent);
  visp.setRobotState(vpRobot::STATE_POSITION_CONTROL);
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::JOINT_STATE, column({0, 0, 0})),
                    Catch::Contains("STATE_VELOCITY_CONTROL"));
}

TEST_CASE("Drives that brake to rest before each move are turned at no velocity") {
  test::ReadyBench bench;
  DrivesFromRestToRest drives(bench.group);
  PlanarRobot robot(bench.robot.arm(), bench.robot.transmission(), drives, bench.clock);
  CHECK_THROWS_MATCHES(robot.turn([](const Joints&) { return Joints(0.1, 0.0, 0.0); }), WorkError,
                       Refused(Cause::kDevice, "they brake to rest first"));
  CHECK(bench.nothing_was_sent());
  CHECK_NOTHROW(robot.move_to({0.1, 0.1, 0.1}));
}

TEST_CASE("A straight arm turns its joints but takes no twist") {
  test::ReadyBench bench;
  VispRobot visp(bench.robot);
  visp.setRobotState(vpRobot::STATE_VELOCITY_CONTROL);
  CHECK_THROWS_WITH(visp.setVelocity(vpRobot::REFERENCE_FRAME, column({0, 0.01, 0, 0, 0, 0})),
                    Catch::Contains("nearly straight"));
  CHECK(bench.nothing_was_sent());
  visp.setVelocity(vpRobot::JOINT_STATE, column({0, 0.1, 0}));
  CHECK(bench.drives[1].targets.size() == 1);
}

TEST_CASE("A drive that fails while the arm turns halts all and is named") {
  TurningBench bench;
  bench.command(vpRobot::JOINT_STATE, column({0.2, 0.1, 0.3}));
  bench.drives[1].fault = "driver error";
  CHECK_THROWS_MATCHES(bench.visp.setVelocity(vpRobot::JOINT_STATE, column({0.2, 0.1, 0.3})),
                       DriveError, Refused(Cause::kDevice, "drive 2"));
  for (const auto& drive : bench.drives) CHECK(drive.halts == 1);
  bench.drives[1].fault.clear();
  bench.robot.energize();
  CHECK_FALSE(bench.robot.move_to({0.2, 0.3 + kPi / 2.0, -0.4}));
}

TEST_CASE("Motors speed up and brake in one time, the slowest at its rated acceleration") {
  const Eigen::Vector3d wanted(3e4, -6e4, 1e4);
  const VelocityMove move = velocity_move({}, 0.0, {}, wanted, rated_limits(), 0.2);
  for (std::size_t i = 0; i < 3; ++i) {
    const double ramp_s = 6e4 / 4e5;  // of motor 2
    CHECK(move.limits[i].speed_pulses_s == Approx(std::abs(wanted[i])));
    CHECK(std::abs(wanted[i]) / move.limits[i].acceleration_pulses_s2 == Approx(ramp_s));
    CHECK(move.targets_pulses[i] == std::lround(wanted[i] * (0.2 + ramp_s / 2.0)));
  }
}

TEST_CASE("Motors that are to rest brake in one time, and keep their goal when told again") {
  std::array<DriveStatus, 3> status = turning({100, 200, 300}, {90000, -90000, 300});
  const VelocityMove last = long_ago({4e4, -8e4, 0.0});
  VelocityMove move = velocity_move(last, 10.0, status, {0.0, 0.0, 0.0}, rated_limits(), 0.2);
  const double ramp_s = 8e4 / 4e5;
  const std::array<std::int32_t, 3> goals = move.targets_pulses;
  CHECK(goals[0] == std::lround(100.0 + 4e4 * ramp_s / 2.0));
  CHECK(goals[1] == std::lround(200.0 - 8e4 * ramp_s / 2.0));
  CHECK(goals[2] == 300);
  // Half of the time later they have gone three quarters of the way.
  status = turning({goals[0] - 1000, goals[1] + 2000, 300}, goals);
  move = velocity_move(move, 10.0 + ramp_s / 2.0, status, {0.0, 0.0, 0.0}, rated_limits(), 0.2);
  CHECK(move.targets_pulses == goals);
  CHECK(move.limits[1].acceleration_pulses_s2 == Approx(4e5));
}

TEST_CASE("A motor that slows down while others go on does so at its rated acceleration") {
  const std::array<DriveStatus, 3> status = turning({0, 0, 0}, {90000, 90000, 90000});
  VelocityMove move = long_ago({1e5, 2e5, 5e4});
  for (const double t_s : {10.0, 10.06, 10.12, 10.18, 10.24}) {
    move = velocity_move(move, t_s, status, {1e4, 2e5, 5e4}, rated_limits(), 0.2);
    CHECK(move.from[0] == Approx(std::max(1e4, 1e5 - 5e5 * (t_s - 10.0))));
  }
}

TEST_CASE("A motor that turns back brakes within its rated acceleration first") {
  const std::array<DriveStatus, 3> status = turning({0, 0, 0}, {90000, 0, 0});
  const VelocityMove move =
      velocity_move(long_ago({5e4, 0.0, 0.0}), 10.0, status, {-5e4, 0.0, 0.0}, rated_limits(), 0.2);
  CHECK(move.limits[0].acceleration_pulses_s2 == Approx(5e5));
  CHECK(move.targets_pulses[0] < -5e4 * 0.2);
}

}  // namespace planar
