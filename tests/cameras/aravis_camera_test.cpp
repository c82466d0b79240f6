#include "planar_servo/hardware/cameras/aravis_camera.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cameras/aravis_kind.h"
#include "planar_servo/machine/rehearsal/gige_camera.h"
#include "support/in_the_end.h"
#include "support/refused.h"
#include "support/scene_sensor.h"

// Every frame here crosses GigE Vision on loopback, through Aravis on both sides.

namespace planar {
namespace {

using test::Refused;

const cv::Size kSensor{320, 240};
const cv::Rect kWhole{0, 0, 320, 240};
constexpr double kFrameRate_hz = 100.0;

// The quickest frame's way is unknown and counts as none. Aravis, where it may read packets from a
// ring, waits for 5 ms until it does, which the kernel rounds up to its ticks.
constexpr double kQuickestWay_s = 0.008;

struct Server {
  explicit Server(test::SceneSensor& sensor, const std::string& serial = "T1")
      : camera("127.0.0.1", serial, kSensor, kFrameRate_hz,
               [&sensor](const cv::Rect& region_px, double brightness) {
                 return sensor.expose(region_px, brightness);
               }) {}
  GigeCamera camera;
};

AravisSettings settings_with(CameraTrigger trigger) {
  AravisSettings settings;
  settings.address = "127.0.0.1";
  settings.sensor_px = kSensor;
  settings.frame_rate_hz = kFrameRate_hz;
  settings.exposure_s = 0.002;
  settings.trigger = trigger;
  settings.packet_size = 9000;
  settings.timeout_s = 1.0;
  return settings;
}

/// The camera's clock is known when some frames have come quickly.
void see_some_frames(FrameSource& camera) {
  for (int i = 0; i < 20; ++i) REQUIRE(camera.next_frame().status == FrameStatus::kOk);
}

TEST_CASE("A frame is whole, of the region asked for, and exposed after it was asked for") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    test::SceneSensor sensor;
    const Server server(sensor);
    const auto opened = open_aravis_camera(settings_with(trigger));
    FrameSource& camera = *opened;
    see_some_frames(camera);
    const cv::Rect regions[] = {
        kWhole, {64, 32, 128, 96}, {65, 33, 128, 96}, {192, 144, 128, 96}, kWhole};
    for (const cv::Rect& region : regions) {
      camera.set_region(region);
      for (int i = 0; i < 3; ++i) {
        const double asked_s = SteadyClock().now_s();
        const FrameResult result = camera.next_frame();
        REQUIRE(result.status == FrameStatus::kOk);
        CHECK(result.frame.region_px == region);
        CHECK(test::SceneSensor::shows(result.frame.image, region));
        CHECK(result.frame.t_s >= asked_s);
        const double way_s = trigger == CameraTrigger::kSoftware ? 0.0 : kQuickestWay_s;
        CHECK(sensor.exposed_s(result.frame.image, region) >= asked_s - way_s);
      }
    }
    CHECK_FALSE(camera.fault());
  }
}

TEST_CASE("A frame that comes late is dated by its own trigger") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  camera.set_region({0, 0, 64, 64});
  sensor.delay_s = 0.2;  // longer than any frame takes
  for (int i = 0; i < 5; ++i) {
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    CHECK(result.frame.t_s <= sensor.exposed_s(result.frame.image, result.frame.region_px));
  }
}

constexpr double kHeldBack_s = 0.2;

TEST_CASE("A frame exposed before it was asked for is not handed over, however late it comes") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kFreeRun));
  FrameSource& camera = *opened;
  see_some_frames(camera);
  for (int i = 0; i < 5; ++i) {
    sensor.delay_s = kHeldBack_s;
    REQUIRE(test::in_the_end([&] { return sensor.delay_s == 0.0; }));  // one is on its way
    SteadyClock().sleep_for_s(kHeldBack_s / 4.0);
    const double asked_s = SteadyClock().now_s();
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    CHECK(sensor.exposed_s(result.frame.image, kWhole) >= asked_s);
  }
}

TEST_CASE("The frame that follows may have been exposed before it was asked for") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    test::SceneSensor sensor;
    const Server server(sensor);
    const auto opened = open_aravis_camera(settings_with(trigger));
    FrameSource& camera = *opened;
    const FrameResult first = camera.next_frame();
    REQUIRE(first.status == FrameStatus::kOk);
    REQUIRE(test::in_the_end([&] { return camera.counts().complete > 20; }));
    const double asked_s = SteadyClock().now_s();
    const FrameResult following = camera.following_frame();
    REQUIRE(following.status == FrameStatus::kOk);
    CHECK(following.frame.id > first.frame.id);
    CHECK(following.frame.t_s < asked_s);
    CHECK(test::SceneSensor::shows(following.frame.image, kWhole));
  }
}

TEST_CASE("Frames keep coming when the camera's count of 16 bits wraps around") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  camera.set_region({0, 0, 64, 64});
  bool wrapped = false;
  std::uint64_t last = 0;
  for (int i = 0; i < 200; ++i) {
    const FrameResult result = camera.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    wrapped = wrapped || result.frame.id < last;
    last = result.frame.id;
  }
  CHECK(wrapped);
}

TEST_CASE("Exposure time and gain reach the sensor") {
  test::SceneSensor sensor;
  const Server server(sensor);
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.exposure_s = 0.005;  // half the usual
  settings.gain_db = 6.0;
  const auto opened = open_aravis_camera(settings);
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  CHECK(sensor.brightness() == Approx(0.5 * std::pow(10.0, 0.3)));
}

TEST_CASE("A new exposure holds for the next frame, an impossible one leaves the old one") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    test::SceneSensor sensor;
    const Server server(sensor);
    const auto opened = open_aravis_camera(settings_with(trigger));
    FrameSource& camera = *opened;
    camera.set_exposure({0.004, 6.0});
    REQUIRE(camera.next_frame().status == FrameStatus::kOk);
    CHECK(sensor.brightness() == Approx(0.4 * std::pow(10.0, 0.3)));
    CHECK(camera.exposure().time_s == 0.004);
    CHECK_THROWS_AS(camera.set_exposure({0.1, 0.0}), InputError);  // longer than a period
    CHECK_THROWS_AS(camera.set_exposure({0.0, 0.0}), InputError);
    CHECK(camera.exposure().gain_db == 6.0);
  }
}

TEST_CASE("A camera that refuses an exposure says what it can do, and keeps the old one") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  const double brightness = sensor.brightness();
  CHECK_THROWS_MATCHES(camera.set_exposure({1e-6, 0.0}), WorkError,
                       Refused(Cause::kInvalid, "exposure of 1 us"));
  CHECK_THROWS_MATCHES(camera.set_exposure({0.004, 1000.0}), WorkError,
                       Refused(Cause::kInvalid, "gain of 1000 dB"));
  CHECK_FALSE(camera.fault());
  CHECK(camera.next_frame().status == FrameStatus::kOk);
  CHECK(sensor.brightness() == brightness);
  CHECK(camera.exposure().time_s == settings_with(CameraTrigger::kSoftware).exposure_s);
  CHECK(camera.counts().reopened == 0);
}

TEST_CASE("Frames that lost packets are counted and never handed over") {
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    test::SceneSensor sensor;
    Server server(sensor);
    AravisSettings settings = settings_with(trigger);
    settings.packet_size = 1500;  // 54 packets a frame
    const auto opened = open_aravis_camera(settings);
    FrameSource& camera = *opened;
    server.camera.lose_packets(0.02);
    int good = 0;
    for (int i = 0; i < 20; ++i) {
      const FrameResult result = camera.next_frame();
      if (result.status != FrameStatus::kOk) continue;
      ++good;
      CHECK(test::SceneSensor::shows(result.frame.image, kWhole));
    }
    CHECK(good > 0);
    CHECK(camera.counts().incomplete > 0);
    server.camera.lose_packets(1.0);
    CHECK(test::in_the_end([&] { return camera.fault().has_value(); }));
    CHECK(camera.next_frame().status != FrameStatus::kOk);
    server.camera.lose_packets(0.0);
    CHECK(test::in_the_end([&] { return camera.next_frame().status == FrameStatus::kOk; }));
  }
}

TEST_CASE("A camera that repeats one picture is at fault until it shows another") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  sensor.frozen = true;
  camera.next_frame();  // the picture may not have been sent before
  CHECK(camera.next_frame().status == FrameStatus::kFrozen);
  CHECK_THAT(camera.fault().value_or(""), Catch::Contains("it repeats one picture"));
  CHECK(camera.counts().frozen > 0);
  sensor.frozen = false;
  CHECK(camera.next_frame().status == FrameStatus::kOk);
  CHECK_FALSE(camera.fault());
}

TEST_CASE("A camera that died and came back keeps its settings and its region") {
  test::SceneSensor sensor;
  auto server = std::make_unique<Server>(sensor);
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.exposure_s = 0.005;
  const auto opened = open_aravis_camera(settings);
  FrameSource& camera = *opened;
  const cv::Rect region{32, 16, 64, 64};
  camera.set_region(region);
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  server.reset();
  CHECK(test::in_the_end([&] { return camera.fault().has_value(); }));
  CHECK(camera.next_frame().status != FrameStatus::kOk);
  server = std::make_unique<Server>(sensor);
  REQUIRE(test::in_the_end([&] { return !camera.fault(); }));
  const FrameResult result = camera.next_frame();
  REQUIRE(result.status == FrameStatus::kOk);
  CHECK(result.frame.region_px == region);
  CHECK(sensor.brightness() == Approx(0.5));
  CHECK(camera.counts().reopened == 1);
}

TEST_CASE("A lost camera refuses an exposure, and no other is taken for it") {
  test::SceneSensor sensor;
  auto server = std::make_unique<Server>(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  server.reset();
  const auto says = [&](const char* words) {
    return test::in_the_end(
        [&] { return camera.fault().value_or("").find(words) != std::string::npos; });
  };
  REQUIRE(says("is lost"));
  CHECK_THROWS_MATCHES(camera.set_exposure({0.004, 6.0}), WorkError,
                       Refused(Cause::kDevice, "the camera is lost"));
  CHECK(camera.exposure().gain_db == 0.0);
  server = std::make_unique<Server>(sensor, "T2");
  CHECK(says("has the serial number T2, not T1"));
  CHECK(camera.next_frame().status == FrameStatus::kLost);
  server.reset();
  server = std::make_unique<Server>(sensor);
  CHECK(test::in_the_end([&] { return !camera.fault(); }));
}

TEST_CASE(
    "A camera that answers but whose frames do not arrive is back with its first frame only") {
  test::SceneSensor sensor;
  Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  REQUIRE(camera.next_frame().status == FrameStatus::kOk);
  server.camera.lose_packets(1.0);
  CHECK(test::in_the_end([&] {
    return camera.fault().value_or("").find("it answers, but none of its frames arrives") !=
           std::string::npos;
  }));
  CHECK_THAT(*camera.fault(), Catch::Contains("firewall") && Catch::Contains("rp_filter") &&
                                  Catch::Contains("packets"));
  CHECK(camera.counts().reopened == 0);
  server.camera.lose_packets(0.0);
  CHECK(test::in_the_end([&] { return !camera.fault(); }));
  CHECK(camera.next_frame().status == FrameStatus::kOk);
  CHECK(camera.counts().reopened == 1);
}

TEST_CASE("Frames that take longer than a lost one would are waited for") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  sensor.pace_s = 0.8;
  for (int i = 0; i < 2; ++i)
    CHECK(test::in_the_end([&] { return camera.next_frame().status == FrameStatus::kOk; }));
  CHECK(camera.next_frame().status == FrameStatus::kOk);
  CHECK(camera.counts().reopened == 0);
}

TEST_CASE("Without its trigger a camera times out and is at fault") {
  test::SceneSensor sensor;
  const Server server(sensor);
  AravisSettings settings = settings_with(CameraTrigger::kHardware);
  settings.timeout_s = 0.05;
  const auto opened = open_aravis_camera(settings);  // the served camera's line never rises
  FrameSource& camera = *opened;
  CHECK(camera.next_frame().status == FrameStatus::kTimeout);
  CHECK(test::in_the_end([&] { return camera.fault().has_value(); }));
}

TEST_CASE("A camera that is not the one asked for is refused by name") {
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), WorkError,
                       Refused(Cause::kDevice, "127.0.0.1"));
  test::SceneSensor sensor;
  const Server server(sensor);
  settings.id = "T2";
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), WorkError,
                       Refused(Cause::kForeign, "T1, not T2"));
  settings.id = "T1";
  settings.sensor_px = {640, 480};
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), WorkError,
                       Refused(Cause::kContradiction, "640 x 480"));
}

TEST_CASE("A camera obeys one program at a time, and the next as soon as that one is gone") {
  test::SceneSensor sensor;
  const Server server(sensor);
  auto first = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  CHECK_THROWS_MATCHES(open_aravis_camera(settings_with(CameraTrigger::kSoftware)), WorkError,
                       Refused(Cause::kBusy, "127.0.0.1"));
  std::thread leaving([&] {
    SteadyClock().sleep_for_s(0.5);
    first.reset();
  });
  const auto next = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  leaving.join();
  CHECK(next->next_frame().status == FrameStatus::kOk);
}

TEST_CASE("What a camera cannot do is said when it is opened") {
  test::SceneSensor sensor;
  const Server server(sensor);
  AravisSettings settings = settings_with(CameraTrigger::kSoftware);
  settings.pixel_format = PixelFormat::kMono12p;
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), WorkError, Refused(Cause::kDevice, "Mono12p"));
  settings = settings_with(CameraTrigger::kSoftware);
  settings.exposure_s = 0.02;
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), InputError,
                       Refused(Cause::kInvalid, "20000 us"));
  settings = settings_with(CameraTrigger::kSoftware);
  settings.address = "localhost";
  CHECK_THROWS_MATCHES(open_aravis_camera(settings), InputError,
                       Refused(Cause::kInvalid, "'localhost'"));
}

TEST_CASE("A region must lie on the sensor") {
  test::SceneSensor sensor;
  const Server server(sensor);
  const auto opened = open_aravis_camera(settings_with(CameraTrigger::kSoftware));
  FrameSource& camera = *opened;
  CHECK_THROWS_AS(camera.set_region({300, 0, 64, 64}), std::invalid_argument);
  CHECK_THROWS_AS(camera.set_region({0, 0, 0, 64}), std::invalid_argument);
}

TEST_CASE("An inspection counts whole and torn frames, and tells why a camera cannot be used") {
  constexpr double kDuration_s = 0.5;
  for (const CameraTrigger trigger : {CameraTrigger::kFreeRun, CameraTrigger::kSoftware}) {
    AravisSettings settings = settings_with(trigger);
    settings.packet_size = 1500;
    {
      test::SceneSensor sensor;
      Server server(sensor);
      const CameraInspection good = inspect_camera(settings, kDuration_s);
      CHECK_FALSE(good.refusal);
      CHECK(good.complete > 0);
      CHECK(good.packet_size == 1500);
      CHECK(good.frame_bytes == static_cast<std::size_t>(kSensor.area()));
      server.camera.lose_packets(0.1);
      CHECK(inspect_camera(settings, kDuration_s).incomplete > 0);
      settings.id = "T2";
      const CameraInspection other = inspect_camera(settings, kDuration_s);
      REQUIRE(other.refusal);
      CHECK_THAT(WorkError(*other.refusal), Refused(Cause::kForeign, "T1, not T2"));
      CHECK_THAT(other.refusal->remedy, Catch::Contains("correct the settings of `camera`"));
    }
    const CameraInspection dead = inspect_camera(settings, kDuration_s);
    REQUIRE(dead.refusal);
    CHECK_THAT(WorkError(*dead.refusal), Refused(Cause::kDevice, "127.0.0.1"));
    CHECK_THAT(dead.refusal->remedy, Catch::StartsWith("ping "));
  }
}

}  // namespace
}  // namespace planar
