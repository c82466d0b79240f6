#include "grbl_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <thread>

#include "board.h"
#include "faulty_line.h"
#include "planar_servo/hardware/drives/grbl_drives.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Fault = std::function<void(FaultyLine&)>;

constexpr std::chrono::milliseconds kPollPeriod{5};
constexpr double kSpeed_pulses_s = 4000.0;  ///< from which the board needs 100 ms to brake
constexpr int kAtFullSpeed_pulses = 800;
constexpr int kFar_pulses = 400000;
constexpr double kPatience_s = 10.0;
constexpr std::chrono::milliseconds kUntilRest{600};

/// What became of a fault. Times count from it, milliseconds.
struct Outcome {
  double detected_ms{0.0}, stop_ms{-1.0},
      rest_ms{0.0};  ///< the stop's is below 0 when none was sent
  double way_pulses{0.0};
  std::string said, to_go_on;
};

/// A board on a line that can be disturbed, on its way at full speed.
class Rig {
 public:
  explicit Rig(const std::filesystem::path& simulator)
      : board_(simulator, kSpeed_pulses_s), line(board_.settings().port, folder_ / "port") {
    GrblSettings settings = board_.settings();
    settings.port = line.port();
    drives = std::make_unique<GrblDrives>(settings);
    drives->energize();
    for (int i = 0; i < 3; ++i) drives->set_position(i, 0);
    drives->set_targets({kFar_pulses, kFar_pulses, kFar_pulses});
    wait([&] { return drives->status()[0].position_pulses >= kAtFullSpeed_pulses; });
  }

  /// Polls until the condition holds; gives up after a while.
  template <typename Condition>
  bool wait(const Condition& holds) {
    const double deadline_s = clock.now_s() + kPatience_s;
    while (!holds()) {
      if (clock.now_s() > deadline_s) return false;
      std::this_thread::sleep_for(kPollPeriod);
    }
    return true;
  }

  /// Ends the fault and switches the board on again, as after any fault.
  void recover() {
    line.mend();
    wait([&] {
      try {
        drives->reconnect();
        drives->energize();
      } catch (const DriveError&) {
        return false;
      }
      return drives->status()[0].energized;
    });
  }

  /// Says what is needed until the board moves again.
  std::string go_on() {
    recover();
    const auto status = drives->status();
    if (!status[0].faults.empty()) return "it does not go on: " + status[0].faults.front();
    if (!status[0].position_certain)
      for (int i = 0; i < 3; ++i) drives->set_position(i, 0);
    const int here = drives->status()[0].position_pulses;
    drives->set_targets({here + 100, here, here});
    wait([&] { return !drives->status()[0].moving; });
    if (drives->status()[0].position_pulses != here + 100) return "it does not move again";
    return status[0].position_certain ? "" : "home";
  }

 private:
  test::TemporaryFolder folder_;
  BenchBoard board_;

 public:
  SteadyClock clock;
  FaultyLine line;
  std::unique_ptr<GrblDrives> drives;
};

/// Breaks a board on its way. `dead` programs no longer ask for its status.
Outcome measure(const std::filesystem::path& simulator, const Fault& fault, bool dead) {
  Rig rig(simulator);
  Outcome outcome;
  const Eigen::Vector3d from_mm = rig.line.position_mm();
  const double fault_s = rig.clock.now_s();
  rig.line.forget_stop();
  fault(rig.line);
  const auto failed = [&] { return !rig.drives->status()[0].faults.empty(); };
  if (!dead) {
    if (!rig.wait(failed)) outcome.said = "NOTHING";
    outcome.detected_ms = 1e3 * (rig.clock.now_s() - fault_s);
    if (const auto status = rig.drives->status(); !status[0].faults.empty())
      outcome.said = status[0].faults.front();
    try {
      rig.drives->halt();
    } catch (const DriveError&) {
      // The board is out of touch.
    }
  }
  std::this_thread::sleep_for(kUntilRest);
  if (const auto stop_s = rig.line.stop_s()) outcome.stop_ms = 1e3 * (*stop_s - fault_s);
  outcome.rest_ms = 1e3 * std::max(0.0, rig.line.last_motion_s() - fault_s);
  outcome.way_pulses = 250.0 * (rig.line.position_mm() - from_mm).cwiseAbs().maxCoeff();
  outcome.to_go_on = rig.go_on();
  return outcome;
}

void print_fault(const char* name, const std::filesystem::path& simulator, int repeats,
                 const Fault& fault, bool dead = false) {
  Outcome worst;
  for (int i = 0; i < repeats; ++i) {
    const Outcome one = measure(simulator, fault, dead);
    worst = {std::max(worst.detected_ms, one.detected_ms),
             std::max(worst.stop_ms, one.stop_ms),
             std::max(worst.rest_ms, one.rest_ms),
             std::max(worst.way_pulses, one.way_pulses),
             one.said,
             one.to_go_on};
  }
  const std::string detected = dead ? "" : fmt::format("{:.1f}", worst.detected_ms);
  const std::string stop = worst.stop_ms < 0.0 ? "" : fmt::format("{:.1f}", worst.stop_ms);
  fmt::print("{:16} {:>9} {:>9} {:9.1f} {:9.0f}  {} [{}]\n", name, detected, stop, worst.rest_ms,
             worst.way_pulses, worst.said, worst.to_go_on);
  std::fflush(stdout);
}

/// What a cell that suits the board, but for its speed, is told.
void print_wrong_settings(const std::filesystem::path& simulator) {
  const BenchBoard board(simulator, kSpeed_pulses_s);
  GrblSettings cell = board.settings();
  cell.axes[0].speed_pulses_s *= 2.0;
  try {
    GrblDrives drives(cell);
    fmt::print("wrong settings   ARE TAKEN\n");
  } catch (const DriveError& error) {
    fmt::print("wrong settings   {}\n", error.what());
  }
}

}  // namespace

void print_fault_table(const std::string& name, const std::filesystem::path& simulator,
                       int repeats) {
  fmt::print("{}: ms from the fault, worst of {}; pulses travelled after it; [to go on]\n", name,
             repeats);
  fmt::print("{:16} {:>9} {:>9} {:>9} {:>9}  said\n", "fault", "detected", "stop sent", "at rest",
             "pulses");
  const auto show = [&](const char* fault, const Fault& deed) {
    print_fault(fault, simulator, repeats, deed);
  };
  show("alarm", [](FaultyLine& line) { line.say_to_program("ALARM:1\r\n"); });
  show("reset in motion", [](FaultyLine& line) { line.say_to_board("\x18"); });
  show("limit input", [](FaultyLine& line) { line.press('X'); });
  show("hold by hand", [](FaultyLine& line) { line.say_to_board("!"); });
  show("garbage", [](FaultyLine& line) { line.say_to_program("\x81\xfe#7\r\n"); });
  show("refused move", [](FaultyLine& line) { line.say_to_program("error:15\r\n"); });
  show("silent board", [](FaultyLine& line) { line.be_silent(); });
  show("line closed", [](FaultyLine& line) { line.unplug(); });
  print_fault(
      "dead program", simulator, repeats, [](FaultyLine&) {}, true);
  print_wrong_settings(simulator);
}

}  // namespace planar
