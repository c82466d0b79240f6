#include "planar_servo/geometry/arm/transmission.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar {
namespace {

MotorDrive drive_of(double speed, double acceleration) {
  MotorDrive drive;
  drive.max_speed_rad_s = speed;
  drive.max_acceleration_rad_s2 = acceleration;
  return drive;
}

}  // namespace

TEST_CASE("A motor's move is that of the virtual drive at every moment, long or short") {
  for (const double to : {1.5, -1.5, 0.35, 0.1, -0.01}) {
    const MotorMove move(0.2, to, drive_of(1.0, 5.0));
    const MotionProfile profile(0.0, {0.2, 0.0}, to, {1.0, 5.0});
    CHECK(move.duration_s() == Approx(profile.end_s()));
    for (int i = -5; i <= 105; ++i) {
      const double t_s = 0.01 * i * profile.end_s();
      CHECK(move.angle_at(t_s) == Approx(profile.state_at(std::max(0.0, t_s)).position));
    }
  }
}

TEST_CASE("A motor that has nowhere to go takes no time, and one without an angle is refused") {
  const MotorMove move(0.2, 0.2, drive_of(1.0, 5.0));
  CHECK(move.duration_s() == 0.0);
  CHECK(move.angle_at(0.0) == 0.2);
  CHECK_THROWS_AS(MotorMove(0.2, std::numeric_limits<double>::quiet_NaN(), drive_of(1.0, 5.0)),
                  std::invalid_argument);
}

}  // namespace planar
