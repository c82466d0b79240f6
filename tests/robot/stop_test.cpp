#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/virtual_cell/virtual_drive.h"
#include "support/manual_clock.h"
#include "support/robot_bench.h"

namespace planar {
namespace {

/// Passes up to this much more time than asked for whenever it sleeps, as a busy computer does.
class LateClock final : public Clock {
 public:
  LateClock(double latest_s, unsigned int seed) : late_s_(0.0, latest_s), random_(seed) {}
  double now_s() const override { return clock_.now_s(); }
  void sleep_for_s(double duration_s) override {
    clock_.sleep_for_s(duration_s + late_s_(random_));
    if (watch) watch();
  }

  std::function<void()> watch;

 private:
  test::ManualClock clock_;
  std::uniform_real_distribution<double> late_s_;
  std::mt19937 random_;
};

VirtualDrive virtual_drive(const Clock& clock, const MotorDrive& motor) {
  VirtualDrive::Settings settings;
  settings.pulses_per_rad =
      motor.direction * motor.pulses_per_motor_turn * motor.gear_ratio / (2.0 * kPi);
  const double scale = std::abs(settings.pulses_per_rad);
  settings.rated_pulses = {scale * motor.max_speed_rad_s, scale * motor.max_acceleration_rad_s2};
  return VirtualDrive(clock, settings, {});
}

}  // namespace

TEST_CASE("A stop never carries a motor beyond its target or back behind its start") {
  const TransmissionSettings settings = test::transmission_settings();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-1.2, 1.2), share(0.0, 1.1);
  for (unsigned int i = 0; i < 400; ++i) {
    LateClock clock(i % 2 == 0 ? 0.0 : 0.15, i);
    std::array<VirtualDrive, 3> drives{virtual_drive(clock, settings.drives[0]),
                                       virtual_drive(clock, settings.drives[1]),
                                       virtual_drive(clock, settings.drives[2])};
    SeparateDrives group({&drives[0], &drives[1], &drives[2]});
    PlanarRobot robot(PlanarArm({{0.3, 0.25}, Rotation::kClockwise}), Transmission(settings), group,
                      clock);
    robot.energize();
    const Joints end{angle(random), angle(random), angle(random)};
    const Pulses target = robot.transmission().pulses_from_joints(end);
    const auto within = [&] {
      for (int j = 0; j < 3; ++j) {
        const int position = drives[static_cast<std::size_t>(j)].status().position_pulses;
        if (position < std::min(0, target[j]) || position > std::max(0, target[j])) return false;
      }
      return true;
    };
    bool always_within = true;
    clock.watch = [&] { always_within = always_within && within(); };
    const double stop_s = share(random) * 1.6;
    robot.move_to(end, [&]() -> std::optional<std::string> {
      if (clock.now_s() < stop_s) return std::nullopt;
      return "stop";
    });
    CAPTURE(i, stop_s, end.transpose());
    CHECK(always_within);
    CHECK(within());
  }
}

}  // namespace planar
