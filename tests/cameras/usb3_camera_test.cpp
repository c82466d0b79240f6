#include "support/usb3_camera.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cameras/aravis_camera.h"
#include "planar_servo/hardware/cameras/aravis_kind.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"
#include "support/in_the_end.h"
#include "support/refused.h"
#include "support/scene_sensor.h"

// Every frame here crosses USB3 Vision, through Aravis and libusb, to a camera emulated below them.

namespace planar {
namespace {

using test::Refused;

const cv::Size kSensor{320, 240};
const cv::Rect kWhole{0, 0, 320, 240};
constexpr double kFrameRate_hz = 50.0;

/// Aravis keeps its libusb context, so all tests of a process share one bus.
test::MockUsbBus& shared_bus() {
  static test::MockUsbBus bus;
  return bus;
}

struct PluggedCamera {
  test::SceneSensor sensor;
  test::Usb3Camera function{"U3V1", kSensor, kFrameRate_hz,
                            [this](const cv::Rect& region_px, double brightness) {
                              return sensor.expose(region_px, brightness);
                            }};
  test::MockUsbDevice device{shared_bus(), function.description(), function};
};

/// Pulses a camera's trigger line at the frame rate.
struct Pulses {
  explicit Pulses(test::Usb3Camera& camera)
      : line([this, &camera] {
          for (SteadyClock clock; !ends; clock.sleep_for_s(1.0 / kFrameRate_hz))
            if (on) {
              ++sent;
              camera.pulse_line();
            }
        }) {}
  ~Pulses() {
    ends = true;
    line.join();
  }
  std::atomic<bool> on{true}, ends{false};
  std::atomic<std::size_t> sent{0};
  std::thread line;
};

AravisSettings settings_with(CameraTrigger trigger) {
  AravisSettings settings;
  settings.sensor_px = kSensor;
  settings.frame_rate_hz = kFrameRate_hz;
  settings.exposure_s = 0.002;
  settings.trigger = trigger;
  settings.timeout_s = 2.0;
  return settings;
}

/// The camera's clock is known when some frames have come quickly.
void see_some_frames(FrameSource& camera) {
  for (int i = 0; i < 20; ++i) REQUIRE(camera.next_frame().status == FrameStatus::kOk);
}

TEST_CASE("A frame over USB is whole, of the region asked for, and exposed after it was asked") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    PluggedCamera plugged;
    const auto opened = open_aravis_camera(settings_with(trigger));
    FrameSource& camera = *opened;
    see_some_frames(camera);
    for (const cv::Rect& region : {kWhole, cv::Rect(64, 32, 128, 96), cv::Rect(65, 33, 128, 96)}) {
      camera.set_region(region);
      for (int i = 0; i < 3; ++i) {
        const double asked_s = SteadyClock().now_s();
        const FrameResult result = camera.next_frame();
        REQUIRE(result.status == FrameStatus::kOk);
        CHECK(result.frame.region_px == region);
        CHECK(test::SceneSensor::shows(result.frame.image, region));
        CHECK(result.frame.t_s >= asked_s);
        CHECK(plugged.sensor.exposed_s(result.frame.image, region) >= asked_s);
      }
    }
  }
}

TEST_CASE("Every grey format arrives with the upper eight bits of its pixels") {
  for (const auto& [format, name] : kPixelFormats) {
    CAPTURE(name);
    PluggedCamera plugged;
    AravisSettings settings = settings_with(CameraTrigger::kSoftware);
    settings.pixel_format = format;
    const auto opened = open_aravis_camera(settings);
    FrameSource& camera = *opened;
    for (const cv::Rect& region : {kWhole, cv::Rect(64, 32, 128, 96)}) {
      camera.set_region(region);
      const FrameResult result = camera.next_frame();
      REQUIRE(result.status == FrameStatus::kOk);
      CHECK(test::SceneSensor::shows(result.frame.image, region));
    }
  }
}

TEST_CASE("Each pulse of the trigger line brings one frame, its absence is a fault") {
  PluggedCamera plugged;
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kHardware));
  FrameSource& camera = *opened;
  Pulses pulses(plugged.function);
  for (int i = 0; i < 5; ++i) {
    const double asked_s = SteadyClock().now_s();
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    CHECK(test::SceneSensor::shows(result.frame.image, kWhole));
    CHECK(result.frame.t_s >= asked_s);
  }
  pulses.on = false;
  CHECK(test::in_the_end([&] { return camera.fault().has_value(); }));
  CHECK(test::in_the_end([&] { return plugged.sensor.exposures() == pulses.sent; }));
  pulses.on = true;
  CHECK(test::in_the_end([&] { return !camera.fault(); }));
  CHECK(camera.next_frame().status == FrameStatus::kOk);
}

constexpr double kHeldBack_s = 0.2;

TEST_CASE("A frame over USB exposed before it was asked for is not handed over, however late") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kHardware}) {
    PluggedCamera plugged;
    const Pulses pulses(plugged.function);  // heeded where they are the trigger
    const auto opened = open_aravis_camera(settings_with(trigger));
    FrameSource& camera = *opened;
    see_some_frames(camera);
    for (int i = 0; i < 5; ++i) {
      plugged.sensor.delay_s = kHeldBack_s;
      REQUIRE(test::in_the_end([&] { return plugged.sensor.delay_s == 0.0; }));  // on its way
      SteadyClock().sleep_for_s(kHeldBack_s / 4.0);
      const double asked_s = SteadyClock().now_s();
      const FrameResult result = camera.next_frame();
      REQUIRE(result.status == FrameStatus::kOk);
      CHECK(plugged.sensor.exposed_s(result.frame.image, kWhole) >= asked_s);
    }
  }
}

TEST_CASE("A camera whose clock is of no use is dated by its frames' arrival") {
  for (const double rate : {0.0, 0.5, 8.0}) {
    PluggedCamera plugged;
    plugged.function.run_clock(rate);
    const auto opened = open_aravis_camera(settings_with(CameraTrigger::kFreeRun));
    FrameSource& camera = *opened;
    for (int i = 0; i < 20; ++i) {
      const double asked_s = SteadyClock().now_s();
      const FrameResult result = camera.next_frame();
      REQUIRE(result.status == FrameStatus::kOk);
      CHECK(result.frame.t_s >= asked_s);
      CHECK(result.frame.t_s <= SteadyClock().now_s());
    }
  }
}

TEST_CASE("Frames over USB without their end are counted and never handed over") {
  PluggedCamera plugged;
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  plugged.function.truncate_payloads(3);
  for (int i = 0; i < 5; ++i) {
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    CHECK(test::SceneSensor::shows(result.frame.image, kWhole));
  }
  CHECK(camera.counts().incomplete >= 3);
  const std::uint64_t cut = camera.counts().incomplete;
  plugged.function.lose_trailers(3);
  for (int i = 0; i < 8; ++i) {
    const FrameResult result = camera.next_frame();
    if (result.status != FrameStatus::kOk) continue;
    CHECK(test::SceneSensor::shows(result.frame.image, kWhole));
  }
  CHECK(camera.counts().incomplete >= cut + 3);
  CHECK(test::in_the_end([&] { return !camera.fault(); }));
}

TEST_CASE("A camera that was unplugged and plugged in again keeps its settings") {
  PluggedCamera plugged;
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.id = "U3V1";
  settings.exposure_s = 0.005;  // half the usual
  const auto opened = open_aravis_camera(settings);
  FrameSource& camera = *opened;
  const cv::Rect region{32, 16, 64, 64};
  camera.set_region(region);
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  plugged.device.unplug();
  plugged.function.power_cycle();
  CHECK(test::in_the_end([&] { return camera.fault().has_value(); }));
  CHECK(camera.next_frame().status != FrameStatus::kOk);
  plugged.device.plug();
  REQUIRE(test::in_the_end([&] { return !camera.fault(); }));
  const FrameResult result = camera.next_frame();
  REQUIRE(result.status == FrameStatus::kOk);
  CHECK(result.frame.region_px == region);
  CHECK(plugged.sensor.brightness() == Approx(0.5));
  CHECK(camera.counts().reopened >= 1);
}

TEST_CASE("A USB camera that is not there is missed by its serial number, those there are named") {
  PluggedCamera plugged;
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.id = "U3V2";
  for (const char* serial : {"U3V2", "U3V1"})
    CHECK_THROWS_MATCHES(open_aravis_camera(settings), WorkError, Refused(Cause::kMissing, serial));
}

TEST_CASE("A USB camera may write its serial number otherwise than the bus, as some makers do") {
  test::SceneSensor sensor;
  test::Usb3Camera function("20497219", kSensor, kFrameRate_hz,
                            [&](const cv::Rect& region_px, double brightness) {
                              return sensor.expose(region_px, brightness);
                            });
  test::UsbDescription description = function.description();
  description.strings[2] = "0138C343";
  const test::MockUsbDevice device(shared_bus(), description, function);
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.id = description.strings[2];
  CHECK(open_aravis_camera(settings)->next_frame().status == FrameStatus::kOk);
}

TEST_CASE("A USB camera is found in /sys, and an inspection counts its frames") {
  PluggedCamera plugged;
  const auto path = find_usb_path("U3V1");
  REQUIRE(path);
  CHECK(path->permitted);
  CHECK(path->speed_bit_s == 5e9);
  const CameraInspection seen = inspect_camera(settings_with(CameraTrigger::kSoftware), 0.5);
  CHECK(seen.complete > 0);
  CHECK(seen.packet_size == 0);
}

TEST_CASE("What a camera does to its pictures is undone at every opening, and told") {
  PluggedCamera plugged;
  plugged.function.set_processing(0.45F, true);
  AravisSettings settings = settings_with(CameraTrigger::kFreeRun);
  const CameraInspection seen = inspect_camera(settings, 0.2);
  CHECK_FALSE(seen.refusal);
  REQUIRE(seen.made_plain.size() == 2);
  CHECK_THAT(seen.made_plain[0], Catch::StartsWith("Gamma was 0.4") && Catch::EndsWith("is 1"));
  CHECK(seen.made_plain[1] == "ReverseX was true and is false");
  CHECK(inspect_camera(settings, 0.2).made_plain.empty());
}

TEST_CASE("A camera that keeps its gamma is refused with what to do") {
  test::SceneSensor sensor;
  test::Usb3Camera function(
      "U3V1", kSensor, kFrameRate_hz,
      [&](const cv::Rect& region_px, double brightness) {
        return sensor.expose(region_px, brightness);
      },
      true);
  function.set_processing(0.45F, false);
  const test::MockUsbDevice device(shared_bus(), function.description(), function);
  const CameraInspection seen = inspect_camera(settings_with(CameraTrigger::kFreeRun), 0.2);
  REQUIRE(seen.refusal);
  CHECK_THAT(WorkError(*seen.refusal), Refused(Cause::kDevice, "Gamma at 0.45"));
  CHECK_THAT(seen.refusal->remedy, Catch::Contains("maker's program"));
}

TEST_CASE("A setting that another program changes is named, and set again") {
  PluggedCamera plugged;
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  see_some_frames(camera);
  const auto features = camera.features();
  const auto gamma = std::find(features.begin(), features.end(),
                               std::pair<std::string, std::string>("Gamma", "1"));
  CHECK(gamma != features.end());
  plugged.function.set_processing(0.45F, false);
  std::string said;
  REQUIRE(test::in_the_end([&] {
    said = camera.fault().value_or(said);
    return said.find("Gamma") != said.npos;
  }));
  CHECK_THAT(said, Catch::Contains("Gamma is 0.4") && Catch::Contains("and was 1") &&
                       Catch::Contains("another program has changed it"));
  REQUIRE(test::in_the_end([&] { return !camera.fault(); }));
  CHECK(camera.next_frame().status == FrameStatus::kOk);
  CHECK(camera.counts().reopened == 1);
}

TEST_CASE("A strobe is set on its line, and compared with the picture without it") {
  PluggedCamera plugged;
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.strobe = {"Line1", 0.0, 0.0};
  const auto judged = [&] {
    const CameraInspection seen = inspect_camera(settings, 0.2);
    REQUIRE_FALSE(seen.refusal);
    return judge_strobe(settings, seen).at(0).verdict;
  };
  CHECK(judged() == Finding::Verdict::kDoubtful);  // the light is always on
  plugged.function.light_by_line(true);
  CHECK(judged() == Finding::Verdict::kWell);
  CHECK(plugged.function.line_source() == 1);
  settings.strobe = {"Line1", 20e-6, 500e-6};
  CHECK(judged() == Finding::Verdict::kWell);
  CHECK(plugged.function.line_source() == 2);
  CHECK(plugged.function.timer_us() == std::pair(20.0F, 500.0F));
  settings.strobe = {"Line7", 0.0, 0.0};
  CHECK_THAT(WorkError(inspect_camera(settings, 0.2).refusal.value()),
             Refused(Cause::kDevice, "Line7"));
  settings.strobe.reset();
  CHECK(judge_strobe(settings, inspect_camera(settings, 0.2)).empty());
}

}  // namespace
}  // namespace planar
