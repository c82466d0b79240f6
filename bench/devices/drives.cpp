// umockdev-wrapper build/release/bin/bench_drives [--repeats N]
// Breaks one of three emulated Tics during a move and measures on the emulated axes when each stood
// still. The columns are the time from the fault to its detection, from detection until the other
// two rested, and from the fault until the broken one rested (ms), and the number of targets sent
// after detection.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <optional>
#include <thread>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/hardware/drives/tic_drives.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "support/tic_bench.h"

namespace planar {
namespace {

using test::TicBench;
using test::UsbFault;

constexpr double kCommandTimeout_s = 0.25;
constexpr double kPulsesPerRad = 2000.0;

/// Notes when a status first tells of a fault, and the targets that are sent after that.
class WatchedDrives final : public ForwardingDrives {
 public:
  WatchedDrives(DriveGroup& drives, Clock& clock) : ForwardingDrives(drives), clock_(clock) {}

  std::optional<double> detected_s;
  int targets_after{0};

  void set_targets(const std::array<std::int32_t, 3>& targets) override {
    if (detected_s) ++targets_after;
    ForwardingDrives::set_targets(targets);
  }
  std::array<DriveStatus, 3> status() override {
    const auto status = ForwardingDrives::status();
    const bool faulty = std::any_of(status.begin(), status.end(),
                                    [](const DriveStatus& drive) { return !drive.faults.empty(); });
    if (faulty && !detected_s) detected_s = clock_.now_s();
    return status;
  }

 private:
  Clock& clock_;
};

TransmissionSettings transmission_settings() {
  TransmissionSettings settings;
  settings.coupling = {Coupling::kAbsolute, Coupling::kAbsolute};
  settings.drives.fill({kPulsesPerRad * 2.0 * kPi, 1.0, 1, 1.0, 8.0});
  settings.limits_rad.fill({-0.4, 1.95});
  return settings;
}

struct Figures {
  double detected_ms{0.0}, others_ms{0.0}, broken_ms{0.0};
  int targets_after{0};
  std::string said;
};

Figures measure(const std::function<void(TicBench&)>& fault) {
  TicBench bench(kCommandTimeout_s);
  TicDrives tics(bench.settings);
  WatchedDrives drives(tics, bench.clock);
  PlanarRobot robot(PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}),
                    Transmission(transmission_settings()), drives, bench.clock);
  robot.energize();
  for (int i = 0; i < 3; ++i) robot.teach_home(i);
  drives.detected_s.reset();
  double fault_s = 0.0;
  std::thread cause([&] {
    while (bench.tics[1].shaft_pulses() < 500)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    fault_s = bench.clock.now_s();
    fault(bench);
  });
  Figures figures;
  try {
    robot.move_to({1.9, 1.9, 1.9});
  } catch (const DriveError& error) {
    figures.said = error.what();
  }
  cause.join();
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const double detected_s = drives.detected_s.value_or(bench.clock.now_s());
  figures.detected_ms = 1e3 * (detected_s - fault_s);
  figures.others_ms =
      1e3 * (std::max(bench.tics[0].last_motion_s(), bench.tics[2].last_motion_s()) - detected_s);
  figures.broken_ms = 1e3 * (bench.tics[1].last_motion_s() - fault_s);
  figures.targets_after = drives.targets_after;
  return figures;
}

void show(const std::string& name, int repeats, const std::function<void(TicBench&)>& fault) {
  Figures worst;
  for (int i = 0; i < repeats; ++i) {
    const Figures one = measure(fault);
    worst.detected_ms = std::max(worst.detected_ms, one.detected_ms);
    worst.others_ms = i == 0 ? one.others_ms : std::max(worst.others_ms, one.others_ms);
    worst.broken_ms = std::max(worst.broken_ms, one.broken_ms);
    worst.targets_after += one.targets_after;
    worst.said = one.said;
  }
  fmt::print("{:24} {:9.1f} {:9.1f} {:9.1f} {:8}  {}\n", name, worst.detected_ms, worst.others_ms,
             worst.broken_ms, worst.targets_after, worst.said);
}

UsbFault of_status(UsbFault::Kind kind, double late_s = 0.0) {
  UsbFault fault{kind, 1, std::uint8_t{0xa1}};
  fault.late_s = late_s;
  return fault;
}

void show_cycle_time() {
  TicBench bench(2.0);
  TicDrives drives(bench.settings);
  std::vector<double> times_ms;
  for (int i = 0; i < 1000; ++i) {
    const double start_s = bench.clock.now_s();
    drives.status();
    times_ms.push_back(1e3 * (bench.clock.now_s() - start_s));
  }
  std::sort(times_ms.begin(), times_ms.end());
  fmt::print("one cycle (feed and status of three drives): median {:.2f} ms, 99 % {:.2f} ms\n",
             times_ms[500], times_ms[990]);
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  using namespace planar;
  CLI::App app("Reaction times of the drives to faults on the wire.");
  int repeats = 5;
  app.add_option("--repeats", repeats, "of each fault; the worst is shown")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  show_cycle_time();
  fmt::print("command timeout {:.0f} ms; worst of {} runs\n", 1e3 * kCommandTimeout_s, repeats);
  fmt::print("{:24} {:>9} {:>9} {:>9} {:>8}  {}\n", "fault", "detected", "others", "broken",
             "targets", "what it said");
  using Kind = UsbFault::Kind;
  show("unplugged", repeats, [](TicBench& b) { b.devices[1].unplug(); });
  show("stalled transfer", repeats,
       [](TicBench& b) { b.devices[1].inject(of_status(Kind::kStall)); });
  show("short transfer", repeats,
       [](TicBench& b) { b.devices[1].inject(of_status(Kind::kShort)); });
  show("late answer, 0.4 s", repeats,
       [](TicBench& b) { b.devices[1].inject(of_status(Kind::kLate, 0.4)); });
  show("silent for good", repeats, [](TicBench& b) { b.devices[1].inject({Kind::kSilence, -1}); });
  show("limit switch", repeats, [](TicBench& b) { b.tics[1].place_switches(-1000, 600); });
  show("low supply", repeats, [](TicBench& b) { b.tics[1].set_supply(3.0); });
  show("kill switch", repeats, [](TicBench& b) { b.tics[1].press_kill_switch(true); });
  show("power cycle", repeats, [](TicBench& b) { b.tics[1].power_cycle(); });
  return 0;
}
