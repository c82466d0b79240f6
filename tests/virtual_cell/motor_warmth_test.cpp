#include "planar_servo/virtual_cell/virtual_drive.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/virtual_cell/virtual_arm.h"
#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

ArmWarmingTruth some_warming() {
  ArmWarmingTruth warming;
  warming.growth = 60e-6;
  warming.zero_shifts_rad << 3e-5, -3e-5, 3e-5;
  warming.motor_time_s = 1500.0;
  warming.link_time_s = 4000.0;
  warming.holding_share = 0.4;
  return warming;
}

/// Turns for this share of every minute until the end.
void work_regularly(MotorWarmth& warmth, double share, double begin_s, double end_s) {
  for (double t_s = begin_s; t_s < end_s; t_s += 60.0) warmth.work(t_s, t_s + share * 60.0, true);
}

}  // namespace

TEST_CASE("A motor is as warm as stated after an hour of regular work, warmer after more of it") {
  MotorWarmth regular(some_warming()), busy(some_warming()), held(some_warming());
  work_regularly(regular, 0.3, 0.0, 3600.0);
  work_regularly(busy, 0.8, 0.0, 3600.0);
  held.work(0.0, 0.0, true);
  CHECK(regular.at(3600.0).motor == Approx(1.0).epsilon(0.01));
  CHECK(regular.at(3600.0).link == Approx(1.0).epsilon(0.01));
  CHECK(busy.at(3600.0).link > 1.3);
  CHECK(held.at(3600.0).link == Approx(0.4 / (0.3 + 0.7 * 0.4)).epsilon(1e-6));
}

TEST_CASE("A link warms later than its motor, goes on while that cools, and cools in the end") {
  MotorWarmth warmth(some_warming());
  work_regularly(warmth, 0.9, 0.0, 1800.0);
  CHECK(warmth.at(600.0 + 1800.0).motor < warmth.at(1800.0).motor);
  MotorWarmth off(some_warming());
  off.work(0.0, 900.0, false);
  CHECK(off.at(300.0).link < 0.5 * off.at(300.0).motor);
  CHECK(off.at(1500.0).motor < off.at(900.0).motor);
  CHECK(off.at(1500.0).link > off.at(900.0).link);
  CHECK(off.at(40000.0).link < 0.01 * off.at(1500.0).link);
}

TEST_CASE("A motor that was never switched on stays cold, and asking warms nothing") {
  const MotorWarmth cold(some_warming());
  CHECK(cold.at(7200.0).motor == 0.0);
  MotorWarmth asked(some_warming()), silent(some_warming());
  for (MotorWarmth* warmth : {&asked, &silent}) warmth->work(10.0, 20.0, true);
  for (double t_s = 10.0; t_s < 100.0; t_s += 1.0) asked.at(t_s);
  CHECK(asked.at(100.0).link == silent.at(100.0).link);
}

TEST_CASE("Links grow and joints turn as the drives' work warms them") {
  Truth truth = draw_truth(1);
  truth.arm.warming = some_warming();
  truth.arm.warming->zero_shifts_rad.setZero();
  const VirtualHardware hardware = test::sample_hardware();
  VirtualClock clock;
  VirtualArm arm(truth, hardware, clock);
  for (int joint = 0; joint < 3; ++joint) arm.drive(joint).energize();
  const double cold_m = arm.tip().p.norm();
  for (int minute = 0; minute < 60; ++minute) {
    for (const double turn : {0.3, 0.0})
      for (int joint = 0; joint < 3; ++joint) {
        const double pulses =
            hardware.pulses_per_rad()[joint] * turn + hardware.home_pulses()[joint];
        arm.drive(joint).set_target(static_cast<std::int32_t>(std::lround(pulses)));
        clock.sleep_for_s(10.0);
      }
  }
  const double grown = arm.tip().p.norm() / cold_m - 1.0;
  constexpr double kPlay = 6e-5;  // of the elbow, which changes the reach
  CHECK(grown > 0.4 * truth.arm.warming->growth - kPlay);
  CHECK(grown < 1.2 * truth.arm.warming->growth + kPlay);
}

}  // namespace planar
