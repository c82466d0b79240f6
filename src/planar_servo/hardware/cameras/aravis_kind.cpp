#include "planar_servo/hardware/cameras/aravis_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/hardware/cameras/aravis_camera.h"
#include "planar_servo/hardware/cameras/aravis_link.h"

namespace planar {
namespace {

constexpr double kTestLateness_s = 0.1, kStrobe_s = 0.2;

/// The remedy where a camera answers but refuses.
constexpr char kCorrectSettings[] =
    "correct the settings of `camera` in the cell file to suit this camera";

/// Takes frames for a while and counts them. Returns the last whole one.
cv::Mat grab(AravisLink& link, const AravisSettings& settings, double duration_s,
             CameraInspection& inspection) {
  SteadyClock clock;
  const double period_s = 1.0 / settings.frame_rate_hz;
  const bool commands = settings.trigger == CameraTrigger::kSoftware;
  const double start_s = clock.now_s();
  double next_s = start_s;
  cv::Mat last;
  while (clock.now_s() < start_s + duration_s) {
    if (commands) {
      clock.sleep_for_s(next_s - clock.now_s());
      next_s = clock.now_s() + period_s;
      link.trigger();
    }
    const auto arrival = link.receive(settings.exposure_s + 2.0 * period_s + kTestLateness_s);
    if (!arrival) continue;
    ++(arrival->complete ? inspection.complete : inspection.incomplete);
    if (arrival->complete)
      last = unpack(settings.pixel_format, arrival->data, arrival->region_px.size());
  }
  return last;
}

/// Returns which share of the pixels that are lit (above half the brightest) is no longer so in the
/// other picture; empty where none is lit.
std::optional<double> darkened_share(const cv::Mat& lit, const cv::Mat& other) {
  if (lit.empty() || other.size() != lit.size()) return std::nullopt;
  double most = 0.0;
  cv::minMaxLoc(lit, nullptr, &most);
  const cv::Mat bright = lit > 0.5 * most;
  const int count = most > 0.0 ? cv::countNonZero(bright) : 0;
  if (count == 0) return std::nullopt;
  return static_cast<double>(cv::countNonZero(bright & (other <= 0.5 * most))) / count;
}

/// Lets the camera expose a while with its strobe off, and compares.
void try_strobe(AravisLink& link, const AravisSettings& settings, const cv::Mat& lit,
                CameraInspection& inspection) {
  constexpr double kFrames = 5.0;
  CameraInspection without;
  link.light(false);
  const double duration_s = std::max(kStrobe_s, kFrames / settings.frame_rate_hz);
  inspection.strobed_share =
      darkened_share(lit, grab(link, settings, duration_s, without)).value_or(0.0);
  link.light(true);
}

using Verdict = Finding::Verdict;

constexpr double kGrab_s = 2.0;
constexpr double kLeastRateShare = 0.9;  ///< of the frames that the file asks for
constexpr double kMegabyte = 1e6;
/// Frames of 26 MB in flight do not fit into the kernel's usual 16 MB.
constexpr int kEnoughUsbMemory_mb = 64;

/// Of a GigE packet: headers of IP, UDP and GVSP within its size; frame, preamble and gap of
/// Ethernet around it, bytes.
constexpr double kPacketHeaders = 20 + 8 + 8, kPacketFrame = 14 + 4 + 8 + 12;
/// The kernel takes in packets at least this often while it is busy (its default of
/// net.core.netdev_budget_usecs).
constexpr double kKernelPause_s = 2e-3;
/// Where drivers that weigh processor time against delay stop (InterruptThrottleRate of Intel's
/// e1000e in its conservative mode).
constexpr double kMostInterrupts_hz = 20000.0;
/// Of 5 Gbit/s about 3.2 carry data [USB 3.0 specification].
constexpr double kUsbShare = 0.64;

std::optional<double> capacity_bytes_s(const CameraInspection& seen, const CameraPath& path) {
  if (!path.speed_bit_s) return std::nullopt;
  const double bytes_s = *path.speed_bit_s / 8.0;
  if (seen.packet_size == 0) return kUsbShare * bytes_s;
  return bytes_s * (seen.packet_size - kPacketHeaders) / (seen.packet_size + kPacketFrame);
}

std::optional<CameraPath> path_of(const AravisSettings& settings) {
  if (settings.address.empty()) return find_usb_path(settings.id);
  return find_network_path(settings.address);
}

/// Says what to do where a camera obeys, but none of its frames arrives.
std::string way_to_frames(const AravisSettings& settings, const CameraInspection& seen,
                          const CameraPath& path) {
  if (settings.trigger == CameraTrigger::kHardware) return "check that the trigger line pulses";
  if (seen.packet_size == 0)
    return "plug the camera into another socket, with a shorter cable; else switch its power off "
           "and on";
  return fmt::format(
      "see what keeps its stream out: a firewall (let UDP from {} in), the reverse path filter "
      "(sudo sysctl -w net.ipv4.conf.all.rp_filter=2 net.ipv4.conf.{}.rp_filter=2), packets of {} "
      "bytes on a way that takes less (set camera.packet_size: 1400); else switch the camera's "
      "power off and on",
      settings.address, path.port, seen.packet_size);
}

constexpr int kMaxPacketSize = 65535;

constexpr Named<CameraTrigger> kTriggers[] = {{CameraTrigger::kFreeRun, "free_run"},
                                              {CameraTrigger::kSoftware, "software"},
                                              {CameraTrigger::kHardware, "hardware"}};

void read_strobe(Fields& fields, CameraStrobe& strobe) {
  fields.text("line", strobe.line);
  if (fields.given("delay_us", false))
    fields.number("delay_us", strobe.delay_s, kMicrosecond, Range::at_least(0.0));
  if (strobe.delay_s > 0.0 || fields.given("duration_us", false))
    fields.number("duration_us", strobe.duration_s, kMicrosecond, Range::positive());
}

struct AravisDetails final : DeviceDetails {
  AravisSettings settings;  ///< but for what every camera has
};

std::vector<Finding> examine_camera(const CameraSettings& camera, const AravisSettings& settings) {
  try {
    const auto path = path_of(settings);
    if (path && !path->permitted)
      return {faulty("camera", {path->port + " may not be opened",
                                fmt::format("{}, then plug the camera in again", kInstallRules), "",
                                Cause::kSystem})};
    const CameraInspection seen = inspect_camera(settings, kGrab_s);
    if (seen.refusal) return {faulty("camera", *seen.refusal)};
    const std::string port = path ? " over " + path->port : "";
    std::vector<Finding> findings{
        {{fmt::format("answers{}{}: {}", settings.address.empty() ? "" : " at " + settings.address,
                      port, seen.identity),
          "", "camera"},
         Verdict::kWell}};
    if (!seen.made_plain.empty())
      findings.push_back(
          {{fmt::format("it changed its pictures: {}", fmt::join(seen.made_plain, "; ")),
            "every opening sets it so; if other programs use the camera, save it as its default",
            "pictures"},
           Verdict::kDoubtful});
    const CameraPath known = path.value_or(CameraPath{});
    for (auto&& judged : {judge_packets(seen, known), judge_bandwidth(camera, seen, known),
                          judge_receiving(camera, seen, known), judge_strobe(settings, seen)})
      findings.insert(findings.end(), judged.begin(), judged.end());
    findings.push_back(judge_frames(camera, settings, seen, known));
    return findings;
  } catch (const InputError& error) {
    return {{{error.what(), "correct the cell file", "camera", error.refusal().cause},
             Verdict::kFaulty}};
  } catch (const WorkError& error) {
    return {faulty("camera", error.refusal())};
  }
}

}  // namespace

CameraInspection inspect_camera(const AravisSettings& settings, double duration_s) {
  require_settings(settings);
  CameraInspection inspection;
  inspection.duration_s = duration_s;
  try {
    FrameMemory memory(settings);
    AravisLink link(settings, memory);
    inspection.identity = link.identity();
    inspection.made_plain = link.made_plain();
    link.start({cv::Point(), settings.sensor_px});
    const cv::Mat picture = grab(link, settings, duration_s, inspection);
    if (settings.strobe) try_strobe(link, settings, picture, inspection);
    inspection.frame_bytes = link.frame_bytes();
    inspection.packet_size = link.packet_size();
    inspection.underruns = link.underruns();
  } catch (const WorkError& error) {
    inspection = {};
    inspection.refusal = error.refusal();
    if (inspection.refusal->remedy.empty()) inspection.refusal->remedy = kCorrectSettings;
  }
  return inspection;
}

std::vector<Finding> judge_packets(const CameraInspection& seen, const CameraPath& path) {
  if (seen.packet_size == 0 || !path.mtu_bytes) return {};
  const std::string what = fmt::format("packets have {} bytes; {} takes up to {}", seen.packet_size,
                                       path.port, *path.mtu_bytes);
  if (seen.packet_size <= *path.mtu_bytes) return {{{what, "", "packets"}, Verdict::kWell}};
  return {{{what,
            fmt::format(
                "sudo ip link set dev {} mtu {}, or set camera.packet_size: {} in the cell file",
                path.port, seen.packet_size, *path.mtu_bytes),
            "packets"},
           Verdict::kFaulty}};
}

std::vector<Finding> judge_bandwidth(const CameraSettings& camera, const CameraInspection& seen,
                                     const CameraPath& path) {
  const auto capacity = capacity_bytes_s(seen, path);
  if (!capacity) return {};
  const double full = static_cast<double>(seen.frame_bytes) * camera.frame_rate_hz;
  const double side_px = camera.follow_region_px;
  const double region = full * side_px * side_px / camera.width_px / camera.height_px;
  const std::string what = fmt::format(
      "at {:.4g} Hz full frames need {:.1f} MB/s and the region's {:.1f} MB/s; {} carries {:.0f} "
      "MB/s",
      camera.frame_rate_hz, full / kMegabyte, region / kMegabyte, path.port, *capacity / kMegabyte);
  if (full <= *capacity) return {{{what, "", "bandwidth"}, Verdict::kWell}};
  const double possible_hz = camera.frame_rate_hz * *capacity / full;
  return {{{what,
            fmt::format("set camera.frame_rate_hz to at most {:.3g}, or use a faster link",
                        possible_hz),
            "bandwidth"},
           region <= *capacity ? Verdict::kDoubtful : Verdict::kFaulty}};
}

std::vector<Finding> judge_receiving(const CameraSettings& camera, const CameraInspection& seen,
                                     const CameraPath& path) {
  if (seen.packet_size == 0 || !path.speed_bit_s) return {};
  std::vector<Finding> findings;
  const auto add = [&](bool well, const std::string& what, const std::string& remedy) {
    findings.push_back(
        {{what, well ? "" : remedy, "receiving"}, well ? Verdict::kWell : Verdict::kDoubtful});
  };
  if (path.socket_bytes)
    add(*path.socket_bytes >= static_cast<double>(seen.frame_bytes),
        fmt::format("a socket holds up to {:.1f} MB; a frame has {:.1f} MB",
                    *path.socket_bytes / kMegabyte,
                    static_cast<double>(seen.frame_bytes) / kMegabyte),
        "sudo sysctl -w net.core.rmem_max=33554432");
  const double packet_s = 8.0 * (seen.packet_size + kPacketFrame) / *path.speed_bit_s;
  if (path.ring)
    add(*path.ring * packet_s >= kKernelPause_s || *path.ring == path.ring_most,
        fmt::format("the ring of {} holds {} packets, {:.1f} ms of them", path.port, *path.ring,
                    1e3 * *path.ring * packet_s),
        fmt::format("sudo ethtool -G {} rx {}", path.port, path.ring_most.value_or(*path.ring)));
  if (path.gathers_us) {
    const double packets_hz = static_cast<double>(seen.frame_bytes) * camera.frame_rate_hz /
                              (seen.packet_size - kPacketHeaders);
    const double interrupts_hz =
        *path.gathers_us == 0 ? packets_hz : std::min(packets_hz, 1e6 / *path.gathers_us);
    add(interrupts_hz <= kMostInterrupts_hz,
        fmt::format("{} interrupts up to {:.0f} times a second", path.port, interrupts_hz),
        fmt::format("sudo ethtool -C {} rx-usecs {:.0f}, or larger packets", path.port,
                    1e6 / kMostInterrupts_hz));
  }
  return findings;
}

std::vector<Finding> judge_strobe(const AravisSettings& settings, const CameraInspection& seen) {
  if (!seen.strobed_share) return {};
  constexpr double kMost = 0.5;
  const std::string& line = settings.strobe->line;
  if (*seen.strobed_share > kMost)
    return {{{fmt::format("{:.0f} % of what is lit is dark without {}", 100.0 * *seen.strobed_share,
                          line),
              "", "strobe"},
             Verdict::kWell}};
  return {{{fmt::format("what is lit stays so without {}: the lamps do not follow it", line),
            fmt::format("check that {} switches the lamps, that they are in view, and that no "
                        "other light is brighter",
                        line),
            "strobe", Cause::kDevice},
           Verdict::kDoubtful}};
}

Finding judge_frames(const CameraSettings& camera, const AravisSettings& settings,
                     const CameraInspection& seen, const CameraPath& path) {
  const double rate_hz = seen.complete / seen.duration_s;
  const std::string what =
      fmt::format("{} whole frames in {:.0f} s, {} with parts missing, {} without memory",
                  seen.complete, seen.duration_s, seen.incomplete, seen.underruns);
  const auto finding = [&](Verdict verdict, const std::string& remedy) {
    return Finding{{what, remedy, "frames", Cause::kDevice}, verdict};
  };
  if (seen.complete == 0 && seen.incomplete == 0)
    return finding(Verdict::kFaulty, way_to_frames(settings, seen, path));
  if (seen.incomplete > 0)
    return finding(seen.complete == 0 ? Verdict::kFaulty : Verdict::kDoubtful,
                   seen.packet_size == 0
                       ? "plug the camera into a socket of its own, with a shorter cable"
                       : fmt::format("sudo sysctl -w net.core.rmem_max=33554432; sudo ethtool -G "
                                     "{} rx 4096",
                                     path.port));
  if (seen.underruns > 0)
    return finding(Verdict::kDoubtful,
                   "end what keeps the processors busy, or lower camera.frame_rate_hz");
  if (rate_hz < kLeastRateShare * camera.frame_rate_hz)
    return finding(Verdict::kDoubtful,
                   fmt::format("end what keeps camera and processors busy, or set "
                               "camera.frame_rate_hz to at most {:.3g}; the file has {:.4g}",
                               rate_hz, camera.frame_rate_hz));
  return finding(Verdict::kWell, "");
}

Finding examine_usb_memory(const std::filesystem::path& parameter) {
  int memory_mb = 0;
  if (!(std::ifstream(parameter) >> memory_mb))
    return {{parameter.string() + " cannot be read", "load the kernel module usbcore", "USB memory",
             Cause::kSystem},
            Verdict::kDoubtful};
  const std::string what = fmt::format("the kernel gives USB {} MB of memory", memory_mb);
  if (memory_mb == 0 || memory_mb >= kEnoughUsbMemory_mb)  // 0: as much as there is
    return {{what, "", "USB memory"}, Verdict::kWell};
  return {{fmt::format("{}; a USB3 camera needs {} MB", what, kEnoughUsbMemory_mb),
           fmt::format("echo 1000 | sudo tee {} (for good: kernel argument "
                       "usbcore.usbfs_memory_mb=1000)",
                       parameter.string()),
           "USB memory"},
          Verdict::kDoubtful};
}

std::shared_ptr<const DeviceDetails> AravisKind::read(Fields& camera) const {
  auto details = std::make_shared<AravisDetails>();
  AravisSettings& settings = details->settings;
  if (camera.given("address", true)) camera.text("address", settings.address);
  if (camera.given("id", true)) camera.text("id", settings.id);
  camera.number("exposure_us", settings.exposure_s, kMicrosecond, Range::positive());
  camera.number("gain_db", settings.gain_db);
  camera.choice("pixel_format", settings.pixel_format, kPixelFormats);
  camera.choice("trigger", settings.trigger, kTriggers);
  if (camera.given("packet_size", true)) {
    std::string size = "auto";
    camera.text("packet_size", size);
    const std::optional<double> bytes = size == "auto" ? 0.0 : finite_number(size);
    const bool fits =
        bytes && *bytes >= 0.0 && *bytes <= kMaxPacketSize && *bytes == std::floor(*bytes);
    camera.check(fits,
                 {fmt::format("camera.packet_size is {}", size),
                  fmt::format("auto or a whole number from 0 to {} is needed", kMaxPacketSize)},
                 "packet_size");
    if (fits) settings.packet_size = static_cast<int>(*bytes);
  }
  if (camera.given("strobe", true))
    camera.map("strobe", [&] { read_strobe(camera, settings.strobe.emplace()); });
  return details;
}

AravisSettings aravis_settings(const CameraSettings& camera) {
  AravisSettings settings = details_of<AravisDetails>(camera).settings;
  settings.sensor_px = {camera.width_px, camera.height_px};
  settings.frame_rate_hz = camera.frame_rate_hz;
  settings.timeout_s = camera.timeout_s;
  return settings;
}

std::shared_ptr<FrameSource> AravisKind::open(const CellSettings& cell) const {
  return open_aravis_camera(aravis_settings(cell.camera));
}

std::vector<Finding> AravisKind::examine(const CellSettings& cell) const {
  const AravisSettings settings = aravis_settings(cell.camera);
  std::vector<Finding> findings = examine_camera(cell.camera, settings);
  if (settings.address.empty()) findings.push_back(examine_usb_memory());
  return findings;
}

}  // namespace planar
