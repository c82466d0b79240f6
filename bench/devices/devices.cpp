// Measures what a served camera and the loop's own part cost: frames per second and CPU by frame
// size, the rate of the free-running loop whose region follows the lamps, and the time from a frame
// to a joint step.

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/hardware/cameras/aravis_camera.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/rehearsal/served_cell.h"

namespace planar {
namespace {

constexpr char kAddress[] = "127.0.0.1";
constexpr double kDuration_s = 5.0;
constexpr double kOpeningTime_s = 1.0;
constexpr int kOwnPartRounds = 2000;

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Serves a cell in a process of its own, so that its CPU time is not counted as ours.
class Server {
 public:
  explicit Server(const CellSettings& cell) : child_(fork()) {
    if (child_ == 0) {
      ServeRequest request;
      request.cell = cell;
      request.address = kAddress;
      request.motor_port = std::filesystem::temp_directory_path() / "bench-grbl";
      const ServedCell served(request);
      for (;;) pause();
    }
    SteadyClock().sleep_for_s(kOpeningTime_s);
  }
  ~Server() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  pid_t child_;
};

AravisSettings settings_of(const CellSettings& cell, double frame_rate_hz) {
  AravisSettings settings;
  settings.address = kAddress;
  settings.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  settings.frame_rate_hz = frame_rate_hz;
  settings.gain_db = 10.0;
  settings.exposure_s = 0.010 / std::sqrt(10.0);  // with this gain as bright as the usual 10 ms
  settings.packet_size = 9000;
  settings.timeout_s = 2.0;
  return settings;
}

nlohmann::json throughput(const CellSettings& cell, int side_px, double asked_hz) {
  const Server server(cell);
  const auto opened = open_aravis_camera(settings_of(cell, asked_hz));
  FrameSource& camera = *opened;
  camera.set_region({0, 0, side_px, side_px});
  camera.next_frame();
  SteadyClock clock;
  const FrameCounts before = camera.counts();
  const double start_s = clock.now_s(), start_cpu_s = cpu_s();
  clock.sleep_for_s(kDuration_s);
  const double elapsed_s = clock.now_s() - start_s;
  const FrameCounts after = camera.counts();
  const double rate_hz = static_cast<double>(after.complete - before.complete) / elapsed_s;
  const double cpu_percent = 100.0 * (cpu_s() - start_cpu_s) / elapsed_s;
  fmt::print(
      "{0:4} x {0:<4} asked {1:5.0f}  got {2:6.1f} frames/s  {3:6.0f} MB/s  CPU {4:3.0f} %  "
      "{5} incomplete\n",
      side_px, asked_hz, rate_hz, rate_hz * side_px * side_px / 1e6, cpu_percent,
      after.incomplete - before.incomplete);
  return {{"side_px", side_px},
          {"asked_hz", asked_hz},
          {"frames_per_s", rate_hz},
          {"cpu_percent", cpu_percent},
          {"incomplete", after.incomplete - before.incomplete}};
}

/// A camera that delivers one and the same frame at once.
class Replay final : public FrameSource {
 public:
  Replay(const Frame& frame, const cv::Size& sensor_px) : frame_(frame), sensor_px_(sensor_px) {}
  cv::Size sensor_size_px() const override { return sensor_px_; }
  void set_region(const cv::Rect& /*region_px*/) override {}
  FrameResult next_frame() override { return {FrameStatus::kOk, frame_}; }
  std::optional<std::string> fault() const override { return std::nullopt; }
  FrameCounts counts() const override { return {}; }
  CameraExposure exposure() const override { return {}; }
  void set_exposure(const CameraExposure& /*exposure*/) override {}

 private:
  Frame frame_;
  cv::Size sensor_px_;
};

double thread_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Returns the time for lamps, workplane, error map and joint step of one frame, in milliseconds of
/// CPU, so that what others do on the machine does not count.
std::vector<double> own_part_ms(const CellSettings& cell, const Frame& frame) {
  Replay replay(frame, {cell.camera.width_px, cell.camera.height_px});
  LampTipSensor sensor(read_vision(cell, true), cell.lamps.method, replay,
                       cell.camera.follow_region_px);
  const PlanarArm arm(cell.arm.geometry);
  const TipPose home = arm.forward(cell.arm.home);
  std::vector<double> times_ms;
  for (int i = 0; i < kOwnPartRounds; ++i) {
    const double start_s = thread_cpu_s();
    const TipMeasurement seen = sensor.measure(home, 1);
    jacobian_law(arm, {cell.arm.home, seen.tip.p, home.p}, 1.0);
    times_ms.push_back(1e3 * (thread_cpu_s() - start_s));
  }
  return times_ms;
}

/// Makes measurement after measurement, each of `frames` frames, with the joint step that follows,
/// and returns the rate reached.
nlohmann::json loop_rate(const CellSettings& cell, double asked_hz, int frames) {
  const Server server(cell);
  const auto opened = open_aravis_camera(settings_of(cell, asked_hz));
  FrameSource& camera = *opened;
  LampTipSensor sensor(read_vision(cell, true), cell.lamps.method, camera,
                       cell.camera.follow_region_px);
  const PlanarArm arm(cell.arm.geometry);
  const TipPose home = arm.forward(cell.arm.home);
  sensor.aim(home);
  sensor.measure(home, 1);
  SteadyClock clock;
  int measured = 0, ok = 0;
  const double start_s = clock.now_s();
  while (clock.now_s() < start_s + kDuration_s) {
    const TipMeasurement seen = sensor.measure(home, frames);
    measured += frames;
    if (!seen.ok()) continue;
    ok += frames;
    jacobian_law(arm, {cell.arm.home, seen.tip.p, home.p}, 1.0);
  }
  const double rate_hz = measured / (clock.now_s() - start_s);
  const std::vector<double> own_ms = own_part_ms(cell, sensor.last_frame());
  const double median_ms = median(own_ms), p99_ms = quantile(own_ms, 0.99);
  fmt::print(
      "free-running loop, region {} px, {} frames a measurement, asked {:.0f}: {:.1f} frames/s, "
      "{} of {} measured; our part {:.3f} ms median, {:.3f} ms at 99 %\n",
      cell.camera.follow_region_px, frames, asked_hz, rate_hz, ok, measured, median_ms, p99_ms);
  return {{"asked_hz", asked_hz},       {"frames_a_measurement", frames},
          {"frames_per_s", rate_hz},    {"measured_share", static_cast<double>(ok) / measured},
          {"own_ms_median", median_ms}, {"own_ms_p99", p99_ms}};
}

}  // namespace

void measure(const std::filesystem::path& cell_file, const std::filesystem::path& json_file) {
  const CellSettings cell = read_cell(cell_file);
  nlohmann::json sizes = nlohmann::json::array();
  sizes.push_back(throughput(cell, 512, 200.0));
  sizes.push_back(throughput(cell, 2048, 60.0));
  sizes.push_back(throughput(cell, 5120, 15.0));
  const nlohmann::json figures{{"throughput", sizes},
                               {"loop", {loop_rate(cell, 300.0, 1), loop_rate(cell, 300.0, 10)}}};
  if (!json_file.empty()) write_file(json_file, figures.dump(2) + "\n");
}

}  // namespace planar

int main(int argc, char** argv) {
  std::filesystem::path cell_file, json_file;
  CLI::App app("Measures cameras over GigE Vision on loopback and the loop's own part.");
  app.add_option("--cell", cell_file, "a virtual cell that is calibrated")->required();
  app.add_option("--json", json_file);
  CLI11_PARSE(app, argc, argv);
  try {
    planar::measure(cell_file, json_file);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
