// device_host: a virtual cell as real devices, a camera on GigE Vision or USB3 Vision and three
// Pololu Tics on USB, and a command that runs against them without knowing it.

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"
#include "device_host/hosted_arm.h"
#include "device_host/hosted_camera.h"
#include "device_host/true_errors.h"
#include "text/atomic_file.h"

namespace planar::test {
namespace {

constexpr int kSkipped = 77;
constexpr double kPoll_s = 0.002;
/// A move is under way for sure so long after its command.
constexpr double kUnderWay_s = 0.3;

struct Options {
  std::filesystem::path cell, targets, run, json;
  std::string camera{"gige"}, fault{"none"};
  double age_s{0.0}, fault_for_s{1.0};
  std::size_t fault_at_command{1};
  std::vector<std::string> command;
};

/// A fault of the camera in the middle of a move, and what followed on the drives' wires.
class FaultScript {
 public:
  FaultScript(const Options& options, HostedArm& arm, HostedCamera& camera)
      : fault_(HostedCamera::fault_named(options.fault)),
        at_command_(options.fault_at_command),
        for_s_(options.fault_for_s),
        arm_(arm),
        camera_(camera) {}

  void poll() {
    if (fault_ == HostedCamera::Fault::kNone) return;
    if (!began_s_ && under_way()) {
      const double now_s = clock_.now_s();
      camera_.set_fault(fault_);
      // What dies slowly may take a last picture.
      began_s_ = std::max(now_s, arm_.true_tips().back().t_s);
    }
    if (began_s_ && !healed_ && clock_.now_s() > *began_s_ + for_s_) {
      healed_ = true;
      camera_.set_fault(HostedCamera::Fault::kNone);
    }
  }

  /// From the fault to the first command to each drive, and to the arm's rest.
  nlohmann::json report() const {
    if (!began_s_) return nullptr;
    nlohmann::json stops_ms = nlohmann::json::array();
    for (std::size_t joint = 0; joint < 3; ++joint)
      for (const double t_s : arm_.drive(joint).commands_s())
        if (t_s > *began_s_) {
          stops_ms.push_back(1e3 * (t_s - *began_s_));
          break;
        }
    return {{"first_command_ms", stops_ms}};
  }

 private:
  bool under_way() {
    const std::vector<double> commands_s = arm_.drive(0).commands_s();
    return commands_s.size() == at_command_ && clock_.now_s() > commands_s.back() + kUnderWay_s &&
           arm_.moving();
  }

  HostedCamera::Fault fault_;
  std::size_t at_command_;
  double for_s_;
  HostedArm& arm_;
  HostedCamera& camera_;
  SteadyClock clock_;
  std::optional<double> began_s_;
  bool healed_{false};
};

/// From the beginning of an exposure to the first command that follows it, milliseconds: of a loop
/// that measures single frames, its own latency.
nlohmann::json exposure_to_command(const std::vector<TrueTip>& tips,
                                   const std::vector<double>& commands_s) {
  std::vector<double> delays_ms;
  for (const double command_s : commands_s) {
    const auto after =
        std::upper_bound(tips.begin(), tips.end(), command_s,
                         [](double t_s, const TrueTip& tip) { return t_s < tip.t_s; });
    if (after != tips.begin()) delays_ms.push_back(1e3 * (command_s - std::prev(after)->t_s));
  }
  if (delays_ms.empty()) return nullptr;
  return {
      {"median", median(delays_ms)}, {"p99", quantile(delays_ms, 0.99)}, {"n", delays_ms.size()}};
}

pid_t start(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& argument : command)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

/// The command's exit status; `poll` is called until it ends.
int wait_for(pid_t child, FaultScript& faults) {
  SteadyClock clock;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    faults.poll();
    clock.sleep_for_s(kPoll_s);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

nlohmann::json score(const Options& options, const std::vector<TrueTip>& tips) {
  const Summary errors = summarize(true_errors(options.targets, options.run, tips));
  fmt::print("true error: {:.4f} mm mean, {:.4f} rms, {:.4f} max over {} targets\n",
             errors.mean / kMillimetre, errors.rms / kMillimetre, errors.max / kMillimetre,
             errors.n);
  return {{"targets", errors.n},
          {"after_mean_mm_truth", errors.mean / kMillimetre},
          {"after_rms_mm_truth", errors.rms / kMillimetre},
          {"after_max_mm_truth", errors.max / kMillimetre}};
}

int host(const Options& options) {
  const CellSettings cell = read_cell(options.cell);
  HostedArm arm(cell, options.age_s);
  MockUsbBus bus;
  std::array<std::optional<MockUsbDevice>, 3> drives;
  for (std::size_t i = 0; i < 3; ++i)
    drives[i].emplace(bus, EmulatedTic::description(HostedArm::serials()[i]), arm.drive(i));
  const cv::Size sensor_px(cell.camera.width_px, cell.camera.height_px);
  const Exposure exposure = [&arm](const cv::Rect& region_px, double brightness) {
    return arm.expose(region_px, brightness);
  };
  const double rate_hz = cell.camera.frame_rate_hz;
  const auto camera = options.camera == "gige" ? host_gige_camera(sensor_px, rate_hz, exposure)
                                               : host_usb_camera(bus, sensor_px, rate_hz, exposure);
  FaultScript faults(options, arm, *camera);
  const int status = wait_for(start(options.command), faults);
  nlohmann::json figures{{"status", status}, {"fault", faults.report()}};
  if (!figures["fault"].is_null())
    fmt::print("{}: first commands to the drives after {} ms\n", options.fault,
               figures["fault"]["first_command_ms"].dump());
  if (!options.run.empty()) figures.update(score(options, arm.true_tips()));
  figures["exposure_to_command_ms"] =
      exposure_to_command(arm.true_tips(), arm.drive(0).commands_s());
  if (!options.json.empty()) write_file(options.json, figures.dump(2) + "\n");
  return status;
}

}  // namespace
}  // namespace planar::test

int main(int argc, char** argv) {
  using planar::test::HostedCamera;
  planar::test::Options options;
  CLI::App app("Serves a virtual cell as real devices and runs a command against them.");
  app.add_option("--cell", options.cell, "the virtual cell, with its truth")->required();
  app.add_option("--camera", options.camera)->check(CLI::IsMember({"gige", "usb"}));
  app.add_option("--age", options.age_s, "what the cell's own clock shows at first, seconds");
  app.add_option("--fault", options.fault)->check(CLI::IsMember(HostedCamera::fault_names()));
  app.add_option("--at-command", options.fault_at_command,
                 "the fault comes during the move that this command to drive 1 began");
  app.add_option("--fault-for", options.fault_for_s, "seconds");
  auto* run = app.add_option("--score", options.run, "folder of the run to be scored afterwards");
  app.add_option("--targets", options.targets, "of that run")->needs(run);
  app.add_option("--json", options.json);
  app.add_option("command", options.command)->required();
  app.positionals_at_end();
  CLI11_PARSE(app, argc, argv);
  try {
    return planar::test::host(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "device_host: {}\n", error.what());
    return planar::test::kSkipped;
  }
}
