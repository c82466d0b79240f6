// device_host: a virtual cell as real devices, a camera on GigE Vision or USB3 Vision and three
// Pololu Tics on USB, and a command that runs against them without knowing it.

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "device_host/fault_script.h"
#include "device_host/hosted_arm.h"
#include "device_host/hosted_camera.h"
#include "device_host/latency.h"
#include "device_host/true_errors.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar::test {
namespace {

constexpr int kSkipped = 77;
constexpr double kPoll_s = 0.002;
constexpr std::size_t kFaultyDrive = 1;  // of joint 2
constexpr char kDriveUnplugged[] = "drive-unplugged", kDrivePowerCycle[] = "drive-power-cycle";
constexpr char kInterrupt[] = "interrupt";  // somebody presses Ctrl-C
constexpr char kQuit[] = "quit";            // Ctrl-\ in the command
constexpr char kHangUp[] = "hang-up";       // the terminal goes away

struct Options {
  std::filesystem::path cell, targets, run, json;
  std::string camera{"gige"};
  std::vector<std::string> faults;
  double age_s{0.0}, fault_for_s{1.0};
  std::vector<std::string> command;
};

nlohmann::json latency(const std::vector<double>& delays_s) {
  if (delays_s.empty()) return nullptr;
  const double median_ms = 1e3 * median(delays_s), p99_ms = 1e3 * quantile(delays_s, 0.99);
  fmt::print("from exposure to command: {:.1f} ms median, {:.1f} ms at 99 % of {} corrections\n",
             median_ms, p99_ms, delays_s.size());
  return {{"median", median_ms}, {"p99", p99_ms}, {"n", delays_s.size()}};
}

pid_t start(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& argument : command)
    arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

/// The command's exit status; the script is played until it ends.
int wait_for(pid_t child, FaultScript& script) {
  SteadyClock clock;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    script.poll();
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

std::vector<std::string> fault_names() {
  std::vector<std::string> names = HostedCamera::fault_names();
  names.insert(names.end(), {kDriveUnplugged, kDrivePowerCycle, kInterrupt, kQuit, kHangUp});
  return names;
}

HostedFault fault_named(const std::string& name, HostedCamera& camera, HostedArm& arm,
                        MockUsbDevice& drive, pid_t command) {
  if (name == kInterrupt) return {name, [command] { kill(command, SIGINT); }, [] {}};
  if (name == kQuit) return {name, [command] { kill(command, SIGQUIT); }, [] {}};
  if (name == kHangUp) return {name, [command] { kill(command, SIGHUP); }, [] {}};
  if (name == kDriveUnplugged)
    return {name, [&drive] { drive.unplug(); }, [&drive] { drive.plug(); }};
  if (name == kDrivePowerCycle) return {name, [&arm] { arm.power_cycle(kFaultyDrive); }, [] {}};
  const HostedCamera::Fault fault = HostedCamera::fault_named(name);
  return {name, [&camera, fault] { camera.set_fault(fault); },
          [&camera] { camera.set_fault(HostedCamera::Fault::kNone); }, true};
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
  const pid_t command = start(options.command);
  std::vector<HostedFault> faults;
  for (const std::string& name : options.faults)
    faults.push_back(fault_named(name, *camera, arm, *drives[kFaultyDrive], command));
  FaultScript script(std::move(faults), arm, options.fault_for_s);
  const int status = wait_for(command, script);
  nlohmann::json figures{{"status", status}, {"faults", script.report()}};
  for (const auto& fault : figures["faults"])
    fmt::print("{}: first commands to the drives after {} ms\n", fault["fault"].get<std::string>(),
               fault["first_command_ms"].dump());
  if (!options.run.empty()) {
    figures.update(score(options, arm.true_tips()));
    figures["exposure_to_command_ms"] =
        latency(exposure_to_command_s(options.run, arm.drive(0).commands_s()));
  }
  if (!options.json.empty()) write_file(options.json, with_format_key("figures", figures.dump(2)));
  return status;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Serves a virtual cell as real devices and runs a command against them.");
  app.add_option("--cell", options.cell, "the virtual cell, with its truth")->required();
  app.add_option("--camera", options.camera)->check(CLI::IsMember({"gige", "usb"}));
  app.add_option("--age", options.age_s, "what the cell's own clock shows at first, seconds");
  app.add_option("--fault", options.faults, "one after the other, each in the middle of a move")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(fault_names()));
  app.add_option("--fault-for", options.fault_for_s, "seconds");
  auto* run = app.add_option("--score", options.run, "folder of the run to be scored afterwards");
  app.add_option("--targets", options.targets, "of that run")->needs(run);
  app.add_option("--json", options.json);
  app.add_option("command", options.command)->required();
  app.positionals_at_end();
  CLI11_PARSE(app, argc, argv);
  return host(options);
}

}  // namespace
}  // namespace planar::test

int main(int argc, char** argv) {
  int status = 1;
  try {
    return planar::test::run(argc, argv);
  } catch (const planar::InputError& error) {
    std::fputs(error.what(), stderr);
  } catch (const planar::WorkError& error) {
    std::fputs(error.what(), stderr);
  } catch (const std::exception& error) {  // umockdev cannot work here
    std::fputs(error.what(), stderr);
    status = planar::test::kSkipped;
  }
  std::fputs("\n", stderr);
  return status;
}
