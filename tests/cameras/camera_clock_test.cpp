#include "planar_servo/hardware/cameras/aravis_link.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

namespace planar {
namespace {

constexpr double kPeriod_s = 1.0 / 15.0;
constexpr double kUptime_s = 5000.0;    // of the host when the camera is switched on
constexpr double kQuickest_s = 0.0015;  // from a stamp to its frame's arrival
constexpr double kRoundOff_s = 1e-9;

/// A camera whose clock runs `rate` times as fast as the host's.
struct StampedCamera {
  double rate;
  double device_s(double t_s) const { return rate * (t_s - kUptime_s); }
};

/// Of every ten frames nine are up to 20 ms late, now and then one by 0.3 s.
class Delays {
 public:
  double next_s() {
    if (++number_ % 10 == 0) return 0.0;
    return number_ % 97 == 0 ? 0.3 : late_s_(generator_);
  }

 private:
  int number_{-1};
  std::mt19937 generator_{20};
  std::uniform_real_distribution<double> late_s_{0.0, 0.02};
};

TEST_CASE("Late frames are dated as if nothing had held them up, whichever way the clocks drift") {
  for (const double drift : {-100e-6, 0.0, 100e-6}) {
    const StampedCamera camera{1.0 + drift};
    CameraClock clock;
    Delays delays;
    double earliest_s = 0.0, latest_s = 0.0;
    for (int i = 0; i < 54000; ++i) {  // an hour
      const double due_s = kUptime_s + i * kPeriod_s + kQuickest_s;
      const double error_s = clock.due_s(camera.device_s(due_s), due_s + delays.next_s()) - due_s;
      earliest_s = std::min(earliest_s, error_s);
      latest_s = std::max(latest_s, error_s);
    }
    // Ten frames lie between two that came quickly; clocks may drift by 700 ppm meanwhile.
    CHECK(latest_s < 700e-6 * 10.0 * kPeriod_s);
    CHECK(earliest_s > -kRoundOff_s);
    CHECK(clock.believed());
  }
}

TEST_CASE("Frames that are all late for a minute do not pass for punctual ones") {
  const StampedCamera camera{1.0};
  CameraClock clock;
  for (int i = 0; i < 900; ++i) {
    const double due_s = kUptime_s + i * kPeriod_s;
    const double late_s = i == 0 ? 0.0 : 0.2;
    CHECK(clock.due_s(camera.device_s(due_s), due_s + late_s) < due_s + 0.04);
  }
}

TEST_CASE("No frame is due after its arrival, whatever the stamps are") {
  std::mt19937 generator(21);
  std::uniform_real_distribution<double> device_s(-1e9, 1e9), pause_s(0.0, 0.2);
  CameraClock clock;
  double arrival_s = kUptime_s;
  for (int i = 0; i < 1000; ++i) {
    arrival_s += pause_s(generator);
    if (i % 50 == 0) clock.begin_stream(arrival_s - 0.01);
    CHECK(clock.due_s(device_s(generator), arrival_s) <= arrival_s);
  }
}

TEST_CASE("A camera's clock that stands still leaves the arrival as the date") {
  Delays delays;
  for (const double device_s : {0.0, 7.0}) {
    CameraClock clock;
    for (int i = 0; i < 100; ++i) {
      const double arrival_s = kUptime_s + i * kPeriod_s + delays.next_s();
      CHECK(clock.due_s(device_s, arrival_s) == Approx(arrival_s).margin(kRoundOff_s));
    }
  }
}

TEST_CASE("After a jump of the camera's clock the next frame's arrival is the new date") {
  for (const double jump_s : {-1000.0, -0.2, 0.2, 1.7e9}) {
    const double round_off_s = std::max(kRoundOff_s, 1e-15 * std::abs(jump_s));
    const StampedCamera camera{1.0};
    CameraClock clock;
    for (int i = 0; i < 100; ++i) {
      const double due_s = kUptime_s + i * kPeriod_s;
      CHECK(clock.due_s(camera.device_s(due_s), due_s) == Approx(due_s).margin(kRoundOff_s));
    }
    for (int i = 100; i < 200; ++i) {
      const double due_s = kUptime_s + i * kPeriod_s;
      const double late_s = i == 150 ? 0.3 : 0.0;
      const double dated_s = clock.due_s(camera.device_s(due_s) + jump_s, due_s + late_s);
      CHECK(std::abs(dated_s - due_s) < 700e-6 * kPeriod_s + round_off_s);
    }
  }
}

TEST_CASE("A camera's clock that runs fast leaves the arrival of punctual frames as the date") {
  for (const double rate : {1.01, 2.0, 1000.0}) {
    const StampedCamera camera{rate};
    CameraClock clock;
    for (int i = 0; i < 1000; ++i) {
      const double arrival_s = kUptime_s + i * kPeriod_s;
      CHECK(clock.due_s(camera.device_s(arrival_s), arrival_s) ==
            Approx(arrival_s).margin(kRoundOff_s));
    }
  }
}

constexpr double kTooLate_s = 0.5;    // then a new stream is begun
constexpr double kStartTime_s = 0.1;  // after which its first frame is exposed

TEST_CASE(
    "A camera's clock that runs slow is found out when frames seem late in a new stream, too") {
  for (const double rate : {0.99, 0.5, 0.125, 1e-3}) {
    const StampedCamera camera{rate};
    CameraClock clock;
    double t_s = kUptime_s;
    const auto seems_late_by_s = [&] { return t_s - clock.due_s(camera.device_s(t_s), t_s); };
    while (seems_late_by_s() < kTooLate_s) t_s += kPeriod_s;
    CHECK(clock.believed());
    clock.begin_stream(t_s);
    t_s += kStartTime_s;
    for (int i = 0; i < 10; ++i, t_s += kPeriod_s) CHECK(seems_late_by_s() == 0.0);
    CHECK_FALSE(clock.believed());
  }
}

TEST_CASE("A queue of frames that ends with its stream does not discredit the camera's clock") {
  const StampedCamera camera{1.0};
  CameraClock clock;
  double t_s = kUptime_s, late_s = 0.0;
  for (; late_s < kTooLate_s; late_s += 0.01, t_s += kPeriod_s)
    CHECK(clock.due_s(camera.device_s(t_s), t_s + late_s) < t_s + 0.01);
  t_s += late_s;
  clock.begin_stream(t_s);
  t_s += kStartTime_s;
  CHECK(clock.due_s(camera.device_s(t_s), t_s) == Approx(t_s).margin(kRoundOff_s));
  CHECK(clock.believed());
  t_s += kPeriod_s;
  CHECK(clock.due_s(camera.device_s(t_s), t_s + 0.3) < t_s + 700e-6 * kPeriod_s);
}

TEST_CASE("A time that is not finite is refused") {
  CameraClock clock;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(clock.due_s(nan, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(clock.due_s(1.0, nan), std::invalid_argument);
}

}  // namespace
}  // namespace planar
