#include "planar_servo/calibration/readings/tracker_clock.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kOffset_s = 37.0, kRate = 50e-6;
constexpr double kStreamPeriod_s = 0.05;

/// A recording of places at random, and the tracker's readings by a clock of its own.
class ClockBench {
 public:
  /// At the last `broken` places the beam is broken, and the arm waits until it is mended.
  explicit ClockBench(int places, unsigned seed = 1, int broken = 0) : random_(seed) {
    std::uniform_real_distribution<double> place(-0.4, 0.4), wait_s(0.0, 0.3);
    Eigen::Vector2d last(0.3, 0.0);
    double t_s = 1000.0;
    for (int i = 0; i < places; ++i) {
      const Eigen::Vector2d p{place(random_), place(random_)};
      const ToolSight sight = cell_.sight("t" + std::to_string(i), p, 0.3, random_);
      const double arrival_s = t_s + 1.0 + (p - last).norm() / 0.1;
      for (int k = 0; k < 3; ++k) {
        LampSight frame;
        frame.id = sight.id;
        frame.t_s = arrival_s + 0.2 + 0.067 * k;
        frame.lamps_px = sight.lamps_px;
        frames.push_back(frame);
      }
      const double mended_s = i < places - broken ? 0.0 : 8.0;
      const double leave_s = frames.back().t_s + 0.5 + wait_s(random_) + mended_s;
      stops_.push_back({arrival_s, leave_s, sight.p_reflector_B});
      t_s = leave_s;
      last = p;
    }
  }

  std::vector<LampSight> frames;

  double tracker_s(double t_s) const { return t_s + kOffset_s + kRate * t_s; }
  double offset_s(const TrackerClock& clock) const {
    return tracker_s(clock.middle_s) - clock.middle_s;
  }

  /// The readings of a tracker that reads all the time, also while the arm moves.
  std::vector<ToolReading> stream() {
    std::vector<ToolReading> readings;
    std::size_t stop = 0;
    for (double t_s = stops_.front().begin_s - 20.0; stop < stops_.size(); t_s += kStreamPeriod_s) {
      while (stop < stops_.size() && t_s > stops_[stop].end_s) ++stop;
      if (stop == stops_.size()) break;
      readings.push_back(read(t_s, where(stop, t_s)));
    }
    return readings;
  }
  /// One reading at each place, some time after its frames.
  std::vector<ToolReading> single() {
    std::vector<ToolReading> readings;
    readings.reserve(stops_.size());
    for (const Stop& stop : stops_) readings.push_back(read(stop.begin_s + 0.45, stop.p_B));
    return readings;
  }

 private:
  struct Stop {
    double begin_s, end_s;
    Eigen::Vector3d p_B;
  };

  Eigen::Vector3d where(std::size_t stop, double t_s) const {
    const Stop& to = stops_[stop];
    if (t_s >= to.begin_s || stop == 0) return to.p_B;
    const Stop& from = stops_[stop - 1];
    return from.p_B + (to.p_B - from.p_B) * ((t_s - from.end_s) / (to.begin_s - from.end_s));
  }
  ToolReading read(double t_s, Eigen::Vector3d p_B) {
    std::normal_distribution<double> noise(0.0, 0.01 * kMillimetre);
    for (double& coordinate : p_B) coordinate += noise(random_);
    return {"scan", tracker_s(t_s), p_B, 0.01 * kMillimetre};
  }

  test::SyntheticCell cell_;
  std::mt19937 random_;
  std::vector<Stop> stops_;
};

void require_clock(const ClockBench& bench, const TrackerClock& clock, double sigma_offset_s,
                   double sigma_rate) {
  INFO("offset " << clock.offset_s << " +- " << clock.sigma_offset_s << " s, rate "
                 << 1e6 * clock.rate << " +- " << 1e6 * clock.sigma_rate << " ppm");
  CHECK(std::abs(clock.offset_s - bench.offset_s(clock)) < 2.0 * clock.sigma_offset_s);
  CHECK(std::abs(clock.rate - kRate) < 4.0 * clock.sigma_rate);
  CHECK(clock.sigma_offset_s < sigma_offset_s);
  CHECK(clock.sigma_rate < sigma_rate);
  for (const double t_s : {1000.0, 2000.0})
    CHECK(clock.camera_time_s(bench.tracker_s(t_s)) == Approx(t_s).margin(2.0 * sigma_offset_s));
}

}  // namespace

TEST_CASE("The clock of a tracker that reads continuously is found to tenths of a second") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ClockBench bench(120, seed);
    const std::vector<ToolReading> resting = readings_at_rest(bench.stream());
    const TrackerClock clock = estimate_tracker_clock(bench.frames, resting);
    CHECK(clock.places > 110);
    require_clock(bench, clock, 0.4, 40e-6);
  }
}

TEST_CASE("Places where the arm waited for a broken beam do not turn the clock") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ClockBench bench(60, seed, 3);
    const TrackerClock clock =
        estimate_tracker_clock(bench.frames, readings_at_rest(bench.stream()));
    require_clock(bench, clock, 0.4, 100e-6);
  }
}

TEST_CASE("The clock is found from one reading at each place, too") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ClockBench bench(60, seed);
    const TrackerClock clock =
        estimate_tracker_clock(bench.frames, readings_at_rest(bench.single()));
    CHECK(clock.places == 60);
    require_clock(bench, clock, 0.4, 1e-6);
  }
}

TEST_CASE("Of a tracker that reads continuously only the readings at rest are kept") {
  ClockBench bench(20);
  const std::vector<ToolReading> stream = bench.stream();
  const std::vector<ToolReading> resting = readings_at_rest(stream);
  CHECK(resting.size() < stream.size() / 2);
  double farthest = 0.0;
  for (std::size_t i = 1; i < resting.size(); ++i)
    if (resting[i].t_s - resting[i - 1].t_s < 1.5 * kStreamPeriod_s)
      farthest = std::max(farthest, (resting[i].p_B - resting[i - 1].p_B).norm());
  CHECK(farthest < 0.12 * kMillimetre);
  CHECK(readings_at_rest(bench.single()).size() == 20);
}

TEST_CASE("A clock that cannot be determined is refused with the reason") {
  ClockBench bench(60), other(60, 2), few(9);
  CHECK_THROWS_MATCHES(estimate_tracker_clock(few.frames, few.single()), InputError,
                       Refused(Cause::kInsufficient, "9 places and 9 rests"));
  CHECK_THROWS_MATCHES(estimate_tracker_clock(bench.frames, other.single()), InputError,
                       Refused(Cause::kContradiction, "tracker"));
  std::vector<ToolReading> milliseconds = bench.single();
  for (ToolReading& reading : milliseconds) reading.t_s *= 1000.0;
  CHECK_THROWS_AS(estimate_tracker_clock(bench.frames, milliseconds), InputError);
  CHECK_THROWS_AS(estimate_tracker_clock(bench.frames, {}), InputError);
}

TEST_CASE("A clock that was set meanwhile is refused, or found as it was in one part") {
  for (double jump_s = 0.6; jump_s < 16.0; jump_s *= 1.35) {
    CAPTURE(jump_s);
    ClockBench bench(30);
    std::vector<ToolReading> readings = bench.single();
    for (std::size_t i = 18; i < readings.size(); ++i) readings[i].t_s += jump_s;
    try {
      const TrackerClock clock = estimate_tracker_clock(bench.frames, readings);
      const double off_s = clock.offset_s - bench.offset_s(clock);
      CHECK(std::min(std::abs(off_s), std::abs(off_s - jump_s)) < 0.7);
    } catch (const InputError& error) {
      CHECK(error.refusal().where == "tracker");
    }
  }
}

TEST_CASE("A tour that is made twice leaves it open which one the tracker read") {
  ClockBench bench(30);
  std::vector<LampSight> twice = bench.frames;
  for (LampSight frame : bench.frames) {
    frame.t_s += 1000.0;
    frame.id += "_again";
    twice.push_back(frame);
  }
  CHECK_THROWS_MATCHES(estimate_tracker_clock(twice, bench.single()), InputError,
                       Refused(Cause::kInsufficient, "offsets of"));
}

}  // namespace planar
