#include "planar_servo/hardware/cameras/aravis_kind.h"

#include <catch2/catch.hpp>

#include "planar_servo/hardware/cameras/aravis_settings.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using Verdict = Finding::Verdict;

/// 2048 x 2048 at 15 Hz with a region of 512 px.
CameraSettings camera_settings() {
  CameraSettings camera;
  camera.width_px = camera.height_px = 2048;
  camera.frame_rate_hz = 15.0;
  camera.follow_region_px = 512;
  return camera;
}

/// What such a camera on GigE does in two seconds when all is well.
CameraInspection good_inspection() {
  CameraInspection seen;
  seen.frame_bytes = std::size_t{2048} * 2048;
  seen.packet_size = 1500;
  seen.duration_s = 2.0;
  seen.complete = 30;
  return seen;
}

const CameraPath kGigabit{"eth0", 1500, 1e9};

TEST_CASE("Little memory for USB is doubtful, with the command that gives more") {
  const test::TemporaryFolder folder;
  const Finding little = examine_usb_memory(folder.write("usbfs_memory_mb", "16\n"));
  CHECK(little.verdict == Verdict::kDoubtful);
  CHECK_THAT(little.remedy, Contains("echo 1000 | sudo tee"));
  CHECK(examine_usb_memory(folder.write("usbfs_memory_mb", "1000\n")).verdict == Verdict::kWell);
  CHECK(examine_usb_memory(folder.path() / "absent").verdict == Verdict::kDoubtful);
}

TEST_CASE(
    "Packets larger than the network takes are a fault, with the command that lets them pass") {
  CameraInspection seen = good_inspection();
  CHECK(judge_packets(seen, kGigabit).at(0).verdict == Verdict::kWell);
  seen.packet_size = 9000;
  const Finding jumbo = judge_packets(seen, kGigabit).at(0);
  CHECK(jumbo.verdict == Verdict::kFaulty);
  CHECK_THAT(jumbo.remedy, Contains("sudo ip link set dev eth0 mtu 9000"));
  seen.packet_size = 0;  // USB
  CHECK(judge_packets(seen, {"/dev/bus/usb/002/003", {}, 5e9}).empty());
}

TEST_CASE("Frames that a link cannot carry are doubtful, the region's too a fault") {
  CameraSettings camera = camera_settings();
  const CameraInspection seen = good_inspection();
  CHECK(judge_bandwidth(camera, seen, kGigabit).at(0).verdict == Verdict::kWell);
  // 1 Gbit/s in packets of 1464 of 1538 bytes carries 119 MB/s; a frame has 4.2 MB.
  camera.frame_rate_hz = 28.0;
  CHECK(judge_bandwidth(camera, seen, kGigabit).at(0).verdict == Verdict::kWell);
  camera.frame_rate_hz = 29.0;
  const Finding full = judge_bandwidth(camera, seen, kGigabit).at(0);
  CHECK(full.verdict == Verdict::kDoubtful);
  CHECK_THAT(full.remedy, Contains("at most 28.4"));
  camera.frame_rate_hz = 500.0;
  CHECK(judge_bandwidth(camera, seen, kGigabit).at(0).verdict == Verdict::kFaulty);
  CHECK(judge_bandwidth(camera, seen, {"lo", 65536, {}}).empty());
}

TEST_CASE("Frames that lack parts, come late or not at all are told with what helps") {
  const CameraSettings camera = camera_settings();
  const CameraInspection good = good_inspection();
  const auto judged = [&](const CameraInspection& seen) {
    return judge_frames(camera, {}, seen, kGigabit);
  };
  CHECK(judged(good).verdict == Verdict::kWell);
  CameraInspection torn = good;
  torn.incomplete = 1;
  CHECK(judged(torn).verdict == Verdict::kDoubtful);
  CHECK_THAT(judged(torn).remedy, Contains("sysctl -w net.core.rmem_max"));
  torn.complete = 0;
  CHECK(judged(torn).verdict == Verdict::kFaulty);
  CameraInspection starved = good;
  starved.underruns = 1;
  CHECK_THAT(judged(starved).remedy, Contains("processors"));
  CameraInspection slow = good;
  slow.complete = 20;
  CHECK_THAT(judged(slow).remedy, Contains("at most 10"));
  CameraInspection silent = good;
  silent.complete = 0;
  CHECK(judged(silent).verdict == Verdict::kFaulty);
  CHECK_THAT(judged(silent).remedy, Contains("firewall") && Contains("conf.eth0.rp_filter=2") &&
                                        Contains("camera.packet_size: 1400"));
  silent.packet_size = 0;  // USB
  CHECK_THAT(judged(silent).remedy, Contains("another socket") && !Contains("firewall"));
}

TEST_CASE("What a socket, a ring and its interrupts take is judged, with the commands") {
  CameraPath path = kGigabit;
  const auto judged = [&] { return judge_receiving(camera_settings(), good_inspection(), path); };
  CHECK(judged().empty());
  path.socket_bytes = 212992;  // what Debian gives
  path.ring = 512;             // 6.3 ms
  path.ring_most = 4096;
  path.gathers_us = 3;
  const auto little = judged();
  REQUIRE(little.size() == 3);
  CHECK_THAT(little[0].remedy, Contains("sysctl -w net.core.rmem_max"));
  CHECK(little[1].verdict == Verdict::kWell);
  CHECK_THAT(little[2].fault, Contains("up to 42974 times a second"));  // once a packet
  CHECK_THAT(little[2].remedy, Contains("ethtool -C eth0 rx-usecs 50"));
  path.ring = 64;
  CHECK_THAT(judged()[1].remedy, Contains("ethtool -G eth0 rx 4096"));
  path.gathers_us = 100;
  CHECK(judged()[2].verdict == Verdict::kWell);
  path.speed_bit_s.reset();  // the loopback
  CHECK(judged().empty());
}

}  // namespace
}  // namespace planar
