#include "planar_servo/loop/servo/path/path_follower.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/loop/servo/path/path_follower.h"
#include "servo/path/moving_bench.h"

namespace planar {
namespace {

using test::MovingBench;
using test::sample_circle;

constexpr double kSpeed_m_s = 0.02;

PlayProbe probe_play(MovingBench& bench) {
  return measure_play(bench.robot, bench.planner, bench.settings, bench.sensor, bench.cell.clock());
}

/// Follows a circle on which something happens after one second.
PathResult follow_with(MovingBench& bench, const std::function<void(TipMeasurement&)>& spoil) {
  double begun_s = -1.0;
  bench.sensor.spoil = [=](TipMeasurement& m) mutable {
    if (begun_s < 0.0) begun_s = m.t_s;
    if (m.t_s > begun_s + 1.0) spoil(m);
  };
  return bench.follow(sample_circle(), kSpeed_m_s, true);
}

/// Drives that turn at a tenth of the speed that they are told, as by a feed override.
class SlowDrives final : public ForwardingDrives {
 public:
  using ForwardingDrives::ForwardingDrives;

  void set_limits(const std::array<DriveLimits, 3>& limits) override {
    std::array<DriveLimits, 3> slower = limits;
    for (DriveLimits& drive : slower) drive.speed_pulses_s *= 0.1;
    ForwardingDrives::set_limits(slower);
  }
};

}  // namespace

TEST_CASE("Vision keeps the end point on a circle that the arm alone misses") {
  MovingBench alone, seeing;
  CHECK(alone.follow(sample_circle(), kSpeed_m_s, false).status == ServoStatus::kReached);
  const PathResult result = seeing.follow(sample_circle(), kSpeed_m_s, true);
  CHECK(result.status == ServoStatus::kReached);
  CHECK(result.reason.empty());
  CHECK(alone.share_below(0.1e-3) < 0.3);
  CHECK(seeing.share_below(0.05e-3) > 0.95);
  CHECK(seeing.rests());
  CHECK((seeing.cell.true_tip().p - Eigen::Vector2d(0.30, 0.15)).norm() < 0.02e-3);
  CHECK(result.duration_s > 0.1 * kPi / kSpeed_m_s);
  CHECK(result.duration_s < 0.1 * kPi / kSpeed_m_s + 2.0);
}

TEST_CASE(
    "Pictures that are understood 40 ms late correct as well, and much later ones do no harm") {
  MovingBench bench;
  bench.sensor.delay_s = 0.04;
  CHECK(bench.follow(sample_circle(), kSpeed_m_s, true).status == ServoStatus::kReached);
  CHECK(bench.share_below(0.03e-3) > 0.9);
  MovingBench slow, alone;
  slow.sensor.delay_s = alone.sensor.delay_s = 0.3;
  CHECK(slow.follow(sample_circle(), kSpeed_m_s, true).status == ServoStatus::kReached);
  alone.follow(sample_circle(), kSpeed_m_s, false);
  CHECK(slow.largest_m() < alone.largest_m());
}

TEST_CASE("A motor that is led through a known play does not leave the path where it turns back") {
  constexpr double kPlay_rad = 1e-3;
  MovingBench unknown(kPlay_rad), known(kPlay_rad);
  known.play_rad = {kPlay_rad, kPlay_rad, 0.0};
  unknown.follow(sample_circle(), kSpeed_m_s, true);
  known.follow(sample_circle(), kSpeed_m_s, true);
  CHECK(known.largest_m() < 0.5 * unknown.largest_m());
}

TEST_CASE("The play is measured where the path begins, and the arm rests there as before") {
  MovingBench bench(1e-3);
  bench.go_to(sample_circle());
  const Joints before = bench.robot.commanded_joints();
  const Eigen::Vector2d p = bench.cell.true_tip().p;
  const PlayProbe probe = probe_play(bench);
  REQUIRE(probe.play_rad);
  CHECK(probe.play_rad->x() == Approx(1e-3).margin(3e-5));
  CHECK(probe.play_rad->y() == Approx(1e-3).margin(3e-5));
  CHECK(probe.play_rad->z() == 0.0);
  CHECK_FALSE(probe.not_back);
  CHECK(bench.robot.commanded_joints() == before);
  CHECK((bench.cell.true_tip().p - p).norm() < 1e-6);
  bench.sensor.spoil = [](TipMeasurement& m) {
    m = failed_look(TipStatus::kNoLamps, "no_lamp", m.t_s);
  };
  const PlayProbe blind = probe_play(bench);
  CHECK_FALSE(blind.play_rad);
  CHECK_FALSE(blind.not_back);
  CHECK(blind.unknown == "the tool was not measured: no_lamp");
  CHECK(bench.robot.commanded_joints() == before);
}

TEST_CASE("A probe of the play that breaks off on its way says that the arm is not back") {
  for (const bool downwards : {false, true}) {
    MovingBench bench;
    bench.settings.approach_margin_rad = 1e-2;
    bench.go_to(sample_circle());
    const Joints before = bench.robot.commanded_joints();
    const Eigen::Vector2d p = bench.cell.true_tip().p;
    bench.robot.stop_when([&] {
      const bool on_its_way = (bench.cell.true_tip().p - p).norm() > 0.3e-3;
      if (on_its_way && bench.sensor.looks == (downwards ? 1 : 0))
        bench.sensor.broken = "it is gone";
      return false;
    });
    const PlayProbe probe = probe_play(bench);
    CHECK_FALSE(probe.play_rad);
    REQUIRE(probe.not_back);
    CHECK_FALSE(probe.not_back->refused);
    CHECK(probe.not_back->reason == "it is gone");
    CHECK_FALSE(bench.robot.commanded_joints() == before);
  }
}

TEST_CASE("Looks that differ by more than play can show tell nothing of it") {
  for (const double off_m : {3e-3, -3e-3}) {
    MovingBench bench(1e-3);
    bench.go_to(sample_circle());
    const Joints before = bench.robot.commanded_joints();
    bench.sensor.spoil = [&](TipMeasurement& m) {
      if (bench.sensor.looks == 1) m.tip.p.x() += off_m;
    };
    const PlayProbe probe = probe_play(bench);
    CHECK_FALSE(probe.play_rad);
    CHECK_FALSE(probe.not_back);
    CHECK_THAT(probe.unknown, Catch::Contains("cannot show more than the approach margin"));
    CHECK(bench.robot.commanded_joints() == before);
  }
}

TEST_CASE("No play is looked for where the place above must not be reached") {
  MovingBench bench;
  bench.go_to(sample_circle());
  bench.settings.approach_margin_rad = 7.0;
  const PlayProbe probe = probe_play(bench);
  CHECK_FALSE(probe.play_rad);
  CHECK_FALSE(probe.not_back);
  CHECK_THAT(probe.unknown, Catch::Contains("motor 1"));
  CHECK(bench.sensor.looks == 0);
}

TEST_CASE("Some lost pictures are borne, half a second without any ends the path at rest") {
  MovingBench bench;
  int lost = 0;
  const auto result = follow_with(bench, [&](TipMeasurement& m) {
    if (++lost <= 5) m = failed_look(TipStatus::kNoPicture, "no_frame", m.t_s);
  });
  CHECK(result.status == ServoStatus::kReached);
  MovingBench blind;
  const auto ended = follow_with(
      blind, [](TipMeasurement& m) { m = failed_look(TipStatus::kNoLamps, "one_lamp", m.t_s); });
  CHECK(ended.status == ServoStatus::kLostLamp);
  CHECK(blind.last.measurement.word == "one_lamp");
  CHECK(blind.rests());
  CHECK(blind.last.along_m < 0.04);
}

TEST_CASE("A look that shows nothing is told with the time at which it was taken") {
  MovingBench bench;
  std::vector<double> times_s;
  bench.go_to(sample_circle());
  bench.sensor.spoil = [&](TipMeasurement& m) {
    if (bench.sensor.looks == 5) m = failed_look(TipStatus::kOutsideView, "outside_view", 0.0);
  };
  PathFollower follower(bench.settings, bench.limits, bench.planner, bench.robot, bench.sensor,
                        bench.cell.clock(), {test::MovingSensor::kPeriod_s, 0.0});
  follower.follow(sample_circle(), PathTiming(sample_circle(), kSpeed_m_s), true,
                  [&](const PathLook& look) { times_s.push_back(look.t_s); });
  CHECK(std::is_sorted(times_s.begin(), times_s.end()));
}

TEST_CASE("A camera that shows one old picture again and again is one that is lost") {
  MovingBench bench;
  std::optional<TipMeasurement> old;
  const auto result = follow_with(bench, [&](TipMeasurement& m) {
    if (!old) old = m;
    m = *old;
  });
  CHECK(result.status == ServoStatus::kLostCamera);
  CHECK_THAT(result.reason, Catch::Contains("frozen_frame"));
  CHECK(bench.last.along_m < 0.04);
  CHECK(bench.rests());
}

TEST_CASE("A path waits for an arm that slowed down because a picture came late") {
  const Path corner({{{{0.20, 0.10}, 0.0}}, {{{0.24, 0.10}, 0.0}}, {{{0.24, 0.16}, 0.0}}});
  const auto follow = [&](double late_s) {
    MovingBench bench;
    double off_m = 0.0;
    bench.sensor.spoil = [&](TipMeasurement&) {
      const Eigen::Vector2d p = bench.cell.true_tip().p;
      const auto from = [&](const PathSegment& segment) {
        return (segment.at(segment.nearest_m(p)).pose.p - p).norm();
      };
      off_m = std::max(off_m, std::min(from(corner.segments()[0]), from(corner.segments()[1])));
      if (bench.sensor.looks == 28) bench.cell.clock().sleep_for_s(late_s);
    };
    const PathResult result = bench.follow(corner, kSpeed_m_s, false);
    CHECK(result.status == ServoStatus::kReached);
    return std::pair(off_m, result.duration_s);
  };
  const auto [usual_m, usual_s] = follow(0.0);
  const auto [late_m, late_s] = follow(1.5);
  CHECK(late_m < usual_m + 0.3e-3);
  CHECK(late_s > usual_s + 1.2);
}

TEST_CASE("Drives that are held back end the path instead of leaving it") {
  MovingBench bench;
  bench.limits.distance_m = 2e-3;
  bench.go_to(sample_circle());
  SlowDrives slow(bench.cell.drives());
  PlanarRobot robot(bench.planner.arm(), bench.planner.transmission(), slow, bench.cell.clock());
  robot.energize();
  PathFollower follower(bench.settings, bench.limits, bench.planner, robot, bench.sensor,
                        bench.cell.clock(), {test::MovingSensor::kPeriod_s, 0.0});
  const PathResult result =
      follower.follow(sample_circle(), PathTiming(sample_circle(), kSpeed_m_s), false);
  CHECK(result.status == ServoStatus::kHeld);
  CHECK(result.cell_in_doubt);
  CHECK_THAT(result.reason, Catch::Contains("from where they were told to be"));
  CHECK(bench.rests());
}

TEST_CASE("An arm whose tool is not seen at the path's beginning does not move") {
  MovingBench bench;
  bench.go_to(sample_circle());
  bench.sensor.spoil = [](TipMeasurement& m) {
    m = failed_look(TipStatus::kNoLamps, "no_lamp", m.t_s);
  };
  const Joints before = bench.robot.commanded_joints();
  CHECK(bench.follow(sample_circle(), kSpeed_m_s, true).status == ServoStatus::kLostLamp);
  CHECK(bench.sensor.looks == 1);
  CHECK(bench.robot.commanded_joints() == before);
}

TEST_CASE("A camera at fault and a look that contradicts the command end the path at rest") {
  MovingBench bench;
  const auto lost =
      follow_with(bench, [&](TipMeasurement&) { bench.sensor.broken = "it is gone"; });
  CHECK(lost.status == ServoStatus::kLostCamera);
  CHECK(lost.reason == "it is gone");
  CHECK(bench.rests());
  MovingBench other;
  const auto held =
      follow_with(other, [](TipMeasurement& m) { m.tip.p += Eigen::Vector2d(0.02, 0.0); });
  CHECK(held.status == ServoStatus::kHeld);
  CHECK(held.cell_in_doubt);
  CHECK(other.rests());
  CHECK(other.last.along_m < 0.03);
}

TEST_CASE("Somebody who stops the arm finds it at rest on the path, and its position kept") {
  MovingBench bench;
  int looks = 0;
  bench.sensor.spoil = [&](TipMeasurement&) { ++looks; };
  bench.go_to(sample_circle());
  bench.robot.stop_when([&] { return looks > 20; });
  CHECK_THROWS_AS(bench.follow(sample_circle(), kSpeed_m_s, true), StopRequested);
  CHECK(bench.rests());
  CHECK(bench.robot.unhomed().empty());
}

TEST_CASE("A look outside the error map's region is said at the end") {
  MovingBench bench;
  const auto result = follow_with(bench, [](TipMeasurement& m) { m.inside_map = false; });
  CHECK(result.status == ServoStatus::kOutsideMap);
}

TEST_CASE("A path round the base begins on the turn from which its motors reach its end") {
  const MovingBench bench;
  const auto circle_from = [](double angle, double sense) {
    const auto at = [&](double turned) {
      return Eigen::Vector2d(0.2 * rotation2d(angle + sense * turned).col(0));
    };
    return Path(
        {{{at(0.0), 0.0}}, {{at(kPi), 0.0}, at(0.5 * kPi)}, {{at(2.0 * kPi), 0.0}, at(1.5 * kPi)}});
  };
  const Transmission& transmission = bench.planner.transmission();
  for (int i = 0; i < 8; ++i)
    for (const double sense : {-1.0, 1.0}) {
      const Path path = circle_from(i * kPi / 4.0, sense);
      const PathDemand demand =
          path_demand(bench.planner, path, PathTiming(path, kSpeed_m_s), {0.3, 1.2, 0.0});
      INFO(i << ", " << sense << ": " << demand.refusal.value_or(""));
      CHECK_FALSE(demand.refusal);
      CHECK_FALSE(transmission.limit_violation(demand.start));
    }
  // Twice round and more is beyond the limits.
  const Path once = circle_from(0.0, 1.0);
  std::vector<Waypoint> places = once.waypoints();
  for (int round = 0; round < 2; ++round)
    places.insert(places.end(), once.waypoints().begin() + 1, once.waypoints().end());
  const Path thrice(places);
  const auto refusal =
      path_demand(bench.planner, thrice, PathTiming(thrice, kSpeed_m_s), {0.3, 1.2, 0.0}).refusal;
  REQUIRE(refusal);
  CHECK_THAT(*refusal, Catch::Contains("unwind a whole turn"));
}

TEST_CASE("What an arm cannot follow is refused with its place on the path") {
  const MovingBench bench;
  const auto demand = [&](const Path& path, double speed_m_s) {
    return path_demand(bench.planner, path, PathTiming(path, speed_m_s), {0.3, 1.2, 0.0});
  };
  const PathDemand circle = demand(sample_circle(), kSpeed_m_s);
  CHECK_FALSE(circle.refusal);
  CHECK(circle.speed_share > 0.05);
  CHECK(circle.speed_share < 0.3);
  const Path outwards({{{{0.5, 0.0}, 0.0}}, {{{0.6, 0.0}, 0.0}}});
  const auto outside = demand(outwards, kSpeed_m_s).refusal;
  REQUIRE(outside);
  CHECK_THAT(*outside, Catch::Contains("40.") && Catch::Contains("mm along the path, at (540."));
  const Path inwards({{{{0.2, 0.061}, 0.0}}, {{{-0.2, 0.061}, 0.0}}});
  const auto too_fast = demand(inwards, 0.3).refusal;
  REQUIRE(too_fast);
  CHECK_THAT(*too_fast, Catch::Contains("motor 1 would have to turn at") &&
                            Catch::Contains("at most 51.6 deg/s"));
}

}  // namespace planar
