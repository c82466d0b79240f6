#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <thread>

#include "planar_servo/base/core/units.h"
#include "planar_servo/hardware/drives/grbl_drives.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "support/eventually.h"
#include "support/grbl_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::eventually;
using test::GrblBench;
using test::Refused;

constexpr double kRecoveryPatience_s = 10.0;
constexpr double kBoardPulsesPerRad = 4000.0;
const Joints kHere{0.0, 0.0, 0.0};
const Joints kAhead{0.1, 0.1, 0.1};
/// Some seconds of travel: long enough to fail on the way.
const Joints kFarAhead{2.9, 2.9, 2.9};

TransmissionSettings geared(HomeReference home) {
  TransmissionSettings settings;
  settings.coupling = {Coupling::kAbsolute, Coupling::kAbsolute};
  for (auto& drive : settings.drives) {
    drive = {kBoardPulsesPerRad * 2.0 * kPi, 1.0, 1, 1.0, 10.0};
    drive.home = home;
  }
  settings.limits_rad.fill({-1.0, 3.0});
  return settings;
}

/// A robot on one Grbl board that is switched on and homed.
struct BoardRobot : GrblBench {
  explicit BoardRobot(HomeReference home = HomeReference::kTaught)
      : GrblBench(home), drives(settings), transmission(geared(home)) {
    if (home != HomeReference::kTaught) board.place_switches(Eigen::Vector3d(0.0, 0.0, 0.0));
    robot.energize();
    home_all();
  }

  void home_all() {
    for (const int joint : robot.unhomed()) {
      if (transmission.settings().drives[0].home == HomeReference::kTaught)
        robot.teach_home(joint);
      else
        robot.search_home(joint);
    }
  }

  /// What the robot says when `fault` happens on its way.
  WorkError failure_of_move(const std::function<void()>& fault) {
    std::thread cause([&] {
      eventually([&] { return board.shafts().x() > 400; });
      fault();
    });
    WorkError failure("", Cause::kInvalid);
    try {
      robot.move_to(kFarAhead);
    } catch (const DriveError& error) {
      failure = WorkError(error.refusal());
      by_hand = dynamic_cast<const StoppedByHand*>(&error) != nullptr;
    }
    cause.join();
    return failure;
  }

  bool nothing_turns() {
    const auto before = board.shafts();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return board.shafts() == before;
  }

  /// Work continues, after homing where the position was lost.
  void check_recovery(bool keeps_position) {
    CHECK(eventually([&] { return nothing_turns(); }));
    CHECK(board.shafts().x() < 11000);
    if (by_hand) {
      CHECK_THROWS_AS(robot.recover(kRecoveryPatience_s), StoppedByHand);
      CHECK(nothing_turns());
      robot.switch_on();
    } else {
      robot.recover(kRecoveryPatience_s);
    }
    CHECK(nothing_turns());
    CHECK(robot.unhomed().empty() == keeps_position);
    if (!keeps_position) {
      CHECK_THROWS_MATCHES(robot.move_to(kAhead), DriveError, Refused(Cause::kDevice, "position"));
      CHECK(nothing_turns());
      home_all();
    }
    const auto here = board.shafts();
    CHECK_FALSE(robot.move_to(kAhead).has_value());
    CHECK(board.shafts() != here);
    const auto status = drives.status();
    for (const DriveStatus& drive : status) CHECK(drive.position_pulses == 400);
  }

  bool by_hand{false};  ///< the last move was stopped so, as its failure says
  GrblDrives drives;
  Transmission transmission;
  SteadyClock clock;
  PlanarRobot robot{PlanarArm({{0.3, 0.25}, Rotation::kCounterclockwise}), transmission, drives,
                    clock};
};

TEST_CASE("A board moves the arm where it should be, and a stop on the way keeps its position") {
  BoardRobot bench;
  CHECK_FALSE(bench.robot.move_to(kAhead).has_value());
  CHECK(bench.board.shafts() == EmulatedGrbl::Pulses(400, 400, 400));
  const auto objection = [&]() -> std::optional<std::string> {
    if (bench.board.shafts().x() < 1000) return std::nullopt;
    return "far enough";
  };
  CHECK(bench.robot.move_to(kFarAhead, objection) == std::optional<std::string>("far enough"));
  CHECK(bench.nothing_turns());
  CHECK(bench.board.shafts().x() < 3000);
  CHECK(bench.robot.unhomed().empty());
  CHECK_FALSE(bench.robot.move_to(kHere).has_value());
  CHECK(bench.board.shafts() == EmulatedGrbl::Pulses(0, 0, 0));
}

TEST_CASE("A limit switch that stops the board asks for homing") {
  BoardRobot bench(HomeReference::kReverseSwitch);
  bench.board.set(21, 1);
  CHECK_THAT(bench.failure_of_move([&] { bench.board.press_limit('Y', true); }),
             Refused(Cause::kDevice, "alarm 1:"));
  bench.board.press_limit('Y', false);
  bench.check_recovery(false);
}

TEST_CASE("A limit input that the board itself does not mind stops the arm, too") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.press_limit('Y', true); }),
             Refused(Cause::kDevice, "switch Y"));
  bench.check_recovery(true);
}

TEST_CASE("An input that has been pressed since before the move does not stop it") {
  BoardRobot bench;
  bench.board.press_limit('X', true);
  CHECK_FALSE(bench.robot.move_to(kAhead).has_value());
}

TEST_CASE("An alarm is explained in words and asks for homing") {
  BoardRobot bench(HomeReference::kForwardSwitch);
  CHECK_THAT(bench.failure_of_move([&] { bench.board.raise_alarm(17); }),
             Refused(Cause::kDevice, "alarm 17:"));
  CHECK_FALSE(bench.by_hand);
  bench.check_recovery(false);
}

TEST_CASE("A reset in motion asks for homing") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.press_reset(); }),
             Refused(Cause::kStopped, "reset"));
  CHECK(bench.by_hand);
  bench.check_recovery(false);
}

TEST_CASE("A hold by hand stops the arm and keeps its position") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.press_hold(); }),
             Refused(Cause::kStopped, "hold"));
  CHECK(bench.by_hand);
  bench.check_recovery(true);
}

TEST_CASE("A program that reads the port while the arm moves is named") {
  BoardRobot bench;
  std::optional<test::PortReader> cat;
  const WorkError failure = bench.failure_of_move([&] {
    cat.emplace(bench.settings.port);
    bench.board.press_hold();
  });
  REQUIRE(cat.has_value());
  CHECK_THAT(failure.what(), Contains(cat->name()));
}

TEST_CASE("A board on hold at rest is resumed when it is switched on again") {
  BoardRobot bench;
  bench.board.press_hold();
  CHECK_THROWS_MATCHES(bench.robot.move_to(kAhead), StoppedByHand,
                       Refused(Cause::kStopped, "hold"));
  bench.by_hand = true;
  bench.check_recovery(true);
}

TEST_CASE("Garbage on the line stops the arm and is shown") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.say("\x81\xfe#7\r\n"); }),
             Refused(Cause::kDevice, "'..#7'"));
  bench.check_recovery(true);
}

TEST_CASE("A single garbled report does not end a move, more of them do") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] {
    bench.board.say("<Jog|MPos:3.000,999.000,3.000|FS:0,0>\r\n");
    bench.board.say("<Jo\x02|MPos:3.0\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    for (int i = 0; i < 3; ++i) bench.board.say("<Jox|MPos:3.0>\r\n");
  }),
             Refused(Cause::kDevice, "'<Jox|MPos:3.0>'"));
  bench.check_recovery(true);
}

TEST_CASE(
    "Two reports of a place where the board was not sent stop it, and its place is looked at "
    "again") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] {
    const std::string report = "<Jog|MPos:3.000,999.000,3.000|FS:0,0>\r\n";
    bench.board.say(report + report);
  }),
             Refused(Cause::kDevice, "off its way"));
  bench.check_recovery(true);
}

TEST_CASE("A board that lost its position without a word stops, and asks for homing") {
  BoardRobot bench;
  bench.robot.move_to(kAhead);
  const WorkError failure = bench.failure_of_move([&] {
    bench.board.be_silent(true);
    bench.board.press_reset();
    bench.board.be_silent(false);
  });
  CHECK_THAT(failure.what(), Contains("off its way") || Contains("stopped on its way"));
  bench.check_recovery(false);
}

TEST_CASE("An answer that is lost on the line does not end a move") {
  BoardRobot bench;
  bench.board.lose_answers(1);
  bench.drives.set_targets({2000, 0, 0});
  CHECK(eventually([&] { return !bench.drives.status()[0].moving; }));
  CHECK(bench.drives.status()[0].position_pulses == 2000);
}

TEST_CASE("A command that the board refuses stops the arm") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.say("error:15\r\n"); }),
             Refused(Cause::kDevice, "error 15:"));
  bench.check_recovery(true);
}

TEST_CASE("A board that falls silent runs no further than what it has queued") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.be_silent(true); }),
             Refused(Cause::kDevice, "190 ms"));
  CHECK(eventually([&] { return bench.nothing_turns(); }));
  bench.board.be_silent(false);
  bench.check_recovery(false);
}

TEST_CASE("A move asks whether to stop while the board is silent, too") {
  BoardRobot bench;
  int asked = 0;
  const auto objection = [&]() -> std::optional<std::string> {
    if (bench.board.shafts().x() < 400) return std::nullopt;
    bench.board.be_silent(true);
    ++asked;
    return std::nullopt;
  };
  CHECK_THROWS_MATCHES(bench.robot.move_to(kFarAhead, objection), DriveError,
                       Refused(Cause::kDevice, "1 s"));
  CHECK(asked > 3);
}

TEST_CASE("A board that says everything but its status is out of touch") {
  BoardRobot bench;
  std::atomic<bool> chatting{true};
  std::thread chatter([&] {
    while (chatting) {
      bench.board.say("[MSG:Caution]\r\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  bench.board.be_silent(true);
  const double begin_s = bench.clock.now_s();
  const auto status = bench.drives.status();
  const double took_s = bench.clock.now_s() - begin_s;
  chatting = false;
  chatter.join();
  for (const DriveStatus& drive : status) CHECK_FALSE(drive.answers);
  CHECK(took_s < 10.0);
}

TEST_CASE("A board that is unplugged runs no further than what it has queued") {
  BoardRobot bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.board.unplug(); }),
             Refused(Cause::kDevice, "unplugged"));
  CHECK(eventually([&] { return bench.nothing_turns(); }));
  CHECK_THROWS_MATCHES(bench.robot.recover(0.1), DriveError,
                       Refused(Cause::kMissing, bench.settings.port));
  bench.board.plug_in();
  bench.check_recovery(false);
}

TEST_CASE("Settings that were changed while a board was unplugged are noticed") {
  BoardRobot bench;
  bench.board.unplug();
  bench.board.set(121, 10.0);
  bench.board.plug_in();
  CHECK_THROWS_MATCHES(bench.robot.move_to(kAhead), DriveError, Refused(Cause::kDevice, "line"));
  CHECK_THROWS_MATCHES(bench.robot.recover(0.1), DriveError,
                       Refused(Cause::kContradiction, "$121 is 10"));
}

}  // namespace
}  // namespace planar
