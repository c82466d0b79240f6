#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/servo/path/path_follower.h"
#include "planar_servo/virtual_cell/virtual_cell.h"
#include "virtual_cell/sample_cell.h"

namespace planar::test {

/// Sees the virtual cell's end point as it is, 15 times a second, and says so later if told to.
class MovingSensor final : public TipSensor {
 public:
  explicit MovingSensor(VirtualCell& cell) : cell_(cell) {}

  double delay_s{0.0};                           ///< from the picture to its position
  std::function<void(TipMeasurement&)> spoil{};  ///< changes what is seen
  std::optional<std::string> broken{};
  int looks{0};

  std::optional<std::string> fault() const override { return broken; }
  TipMeasurement measure(const TipPose& /*expected*/, int frames) override {
    ++looks;
    Clock& clock = cell_.clock();
    const double next_s = std::ceil(clock.now_s() / kPeriod_s + 1e-6) * kPeriod_s;
    clock.sleep_for_s(next_s - clock.now_s());
    TipMeasurement measurement;
    measurement.t_s = clock.now_s();
    measurement.frames = frames;
    measurement.tip = cell_.true_tip();
    clock.sleep_for_s(delay_s);
    if (spoil) spoil(measurement);
    return measurement;
  }

  static constexpr double kPeriod_s{1.0 / 15.0};

 private:
  VirtualCell& cell_;
};

/// An arm with links, gears and play that its files do not know, before a path.
struct MovingBench {
  explicit MovingBench(double true_play_rad = 1e-4)
      : cell(truth_with(true_play_rad), sample_hardware()) {
    robot.energize();
    settings.approach_margin_rad = 2e-3;
  }

  /// Rests at the path's beginning, every motor from below.
  void go_to(const Path& path) {
    const JointPlan plan = planner.plan(path.at(0.0).pose, robot.commanded_joints());
    REQUIRE_FALSE(plan.refusal);
    const auto obstacle = arrive(robot, planner, settings, plan.theta, {});
    INFO((obstacle ? obstacle->reason : ""));
    REQUIRE_FALSE(obstacle);
  }

  /// Goes to the path's beginning and follows it. Keeps the true distances from it, largest first.
  PathResult follow(const Path& path, double speed_m_s, bool by_vision) {
    go_to(path);
    PathFollower follower(settings, limits, planner, robot, sensor, cell.clock(),
                          {MovingSensor::kPeriod_s, 0.0});
    follower.set_play(play_rad);
    deviations_m.clear();
    return follower.follow(path, PathTiming(path, speed_m_s), by_vision, [&](const PathLook& look) {
      deviations_m.push_back(std::abs(path.offset(cell.true_tip().p, look.along_now_m).across_m));
      last = look;
    });
  }

  double share_below(double deviation_m) const {
    const auto below = std::count_if(deviations_m.begin(), deviations_m.end(),
                                     [&](double d) { return d < deviation_m; });
    return static_cast<double>(below) / static_cast<double>(deviations_m.size());
  }
  double largest_m() const { return *std::max_element(deviations_m.begin(), deviations_m.end()); }

  bool rests() {
    const auto status = cell.drives().status();
    return std::none_of(status.begin(), status.end(), [](const auto& s) { return s.moving; });
  }

  static Truth truth_with(double true_play_rad) {
    Truth truth = draw_truth(5);
    truth.arm = {};
    truth.arm.link_lengths_m = {0.2998, 0.3003};
    for (ReducerTruth& reducer : truth.arm.reducers) {
      reducer.backlash_rad = true_play_rad;
      reducer.zero_offset_rad = 5e-4;
    }
    return truth;
  }
  static TransmissionSettings drives() {
    TransmissionSettings settings;
    settings.drives[0] = {10000.0, 100.0, 1, 1.0, 5.0};
    settings.drives[1] = {10000.0, 100.0, -1, 1.0, 5.0};
    settings.drives[2] = {10000.0, 50.0, 1, 2.0, 10.0};
    settings.limits_rad.fill({-6.0, 6.0});
    return settings;
  }

  VirtualCell cell;
  MovingSensor sensor{cell};
  JointPlanner planner{PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}), Transmission(drives()),
                       Workspace{0.06, 0.54, {}}, Elbow::kRight};
  PlanarRobot robot{planner.arm(), planner.transmission(), cell.drives(), cell.clock()};
  ServoSettings settings;
  GuardLimits limits;
  Eigen::Vector3d play_rad{0.0, 0.0, 0.0};
  std::vector<double> deviations_m;
  PathLook last;
};

/// A circle of 50 mm about (0.25, 0.15) m, in two arcs.
inline Path sample_circle() {
  return Path({{{{0.30, 0.15}, 0.0}},
               {{{0.20, 0.15}, 0.0}, Eigen::Vector2d(0.25, 0.20)},
               {{{0.30, 0.15}, 0.0}, Eigen::Vector2d(0.25, 0.10)}});
}

}  // namespace planar::test
