// A million looks of the positioning loop in virtual time, with random faults in between: does the
// arm always stop, and does memory stay what it is?  bench_soak [LOOKS] [SEED]
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "support/simulated_cell.h"

namespace planar {
namespace {

TransmissionSettings transmission_settings() {
  TransmissionSettings settings;
  for (std::size_t i = 0; i < 3; ++i)
    settings.drives[i] = {10000.0, i == 2 ? 50.0 : 100.0, 1, 1.0, 5.0};
  settings.limits_rad.fill({-6.0, 6.0});
  return settings;
}

test::SimulatedCell::Truth plant() {
  test::SimulatedCell::Truth truth;
  truth.pulses_per_rad = Transmission(transmission_settings()).pulses_per_rad();
  return truth;
}

double resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  double size = 0.0, resident = 0.0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

enum class Injected { kNone, kLamp, kBlind, kDrive, kOffset, kNotFinite, kStop, kKinds };

class Soak {
 public:
  explicit Soak(unsigned seed)
      : random_(seed),
        planner_(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}),
                 Transmission(transmission_settings()), {0.06, 0.54, {}}, Elbow::kLeft, 0.01),
        robot_(planner_.arm(), planner_.transmission(), cell_.drives(), cell_.clock()),
        servo_({}, {}, planner_, robot_, sensor_, cell_.clock(), &landings_) {
    robot_.energize();
    robot_.stop_when([this] { return cell_.now_s() > stop_s_; });
  }

  int looks() const { return sensor_.measurements; }

  /// Moves to a random target, in one of five times with a fault.
  void step() {
    const bool faulty = random_() % 5 == 0;
    const auto kinds = static_cast<unsigned>(Injected::kKinds) - 1;
    const auto fault = faulty ? static_cast<Injected>(1 + random_() % kinds) : Injected::kNone;
    inject(fault);
    const std::string outcome = move();
    judge(fault, outcome);
    ++outcomes[outcome];
    mend();
  }

  std::map<std::string, long> outcomes;
  long faults{0}, missed{0};

 private:
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

  void inject(Injected fault) {
    const double soon_s = cell_.now_s() + uniform(0.0, 1.0);
    if (fault == Injected::kLamp) sensor_.lamp_lost_from = sensor_.measurements;
    if (fault == Injected::kBlind) sensor_.blind_from_s = soon_s;
    if (fault == Injected::kDrive)
      cell_.drive(static_cast<int>(random_() % 3)).fault_on_the_way = "x";
    if (fault == Injected::kOffset) sensor_.offset_m = {0.05, 0.0};
    if (fault == Injected::kNotFinite) sensor_.offset_m.x() = std::nan("");
    if (fault == Injected::kStop) stop_s_ = soon_s;
  }

  std::string move() {
    const double r = uniform(0.15, 0.5), a = uniform(-3.0, 3.0);
    try {
      return name(servo_.move_to({r * rotation2d(a).col(0), uniform(-1.0, 1.0)}).status);
    } catch (const StopRequested&) {
      return "stopped";
    } catch (const DriveError&) {
      return "drive error";
    }
  }

  /// Counts what a fault did not stop: an arm that still moves, or a target that was called
  /// reached although the fault was there from the start of its looks.
  void judge(Injected fault, const std::string& outcome) {
    if (fault != Injected::kNone) ++faults;
    bool moving = false;
    for (int i = 0; i < 3; ++i) moving = moving || cell_.drive(i).status().moving;
    const bool from_start = fault == Injected::kLamp || fault == Injected::kOffset ||
                            fault == Injected::kNotFinite || fault == Injected::kDrive;
    if (moving || (from_start && outcome == "reached")) ++missed;
  }

  void mend() {
    sensor_.lamp_lost_from.reset();
    sensor_.blind_from_s.reset();
    sensor_.offset_m.setZero();
    stop_s_ = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      test::MockPulseDrive& drive = cell_.drive(i);
      drive.fault_on_the_way.clear();
      if (drive.targets.size() > 1) drive.targets.assign(1, drive.targets.back());
      drive.targets.assign(1, drive.status().position_pulses);
    }
    robot_.recover(1.0);
  }

  std::mt19937 random_;
  test::SimulatedCell cell_{plant()};
  test::SimulatedSensor sensor_{cell_};
  double stop_s_{std::numeric_limits<double>::infinity()};
  JointPlanner planner_;
  PlanarRobot robot_;
  UnknownLandings landings_{GuardLimits().distance_m};
  PositionServo servo_;
};

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  const int looks = argc > 1 ? std::atoi(argv[1]) : 1000000;
  planar::Soak soak(argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U);
  double settled_bytes = 0.0;
  while (soak.looks() < looks) {
    soak.step();
    if (settled_bytes == 0.0 && soak.looks() > looks / 10) settled_bytes = planar::resident_bytes();
  }
  const double growth = planar::resident_bytes() / settled_bytes - 1.0;
  for (const auto& [outcome, count] : soak.outcomes) fmt::print("{:14} {}\n", outcome, count);
  fmt::print(
      "{} looks, {} faults, {} stops missed (bound 0); memory grew by {:.2f} % (bound 1 %)\n",
      soak.looks(), soak.faults, soak.missed, 100.0 * growth);
  return soak.missed == 0 && growth < 0.01 ? 0 : 1;
}
