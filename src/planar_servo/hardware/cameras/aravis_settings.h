#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "planar_servo/base/core/text.h"

namespace planar {

/// Formats in which cameras send grey pixels, named by GenICam's pixel format naming convention.
/// "Mono10" and "Mono12" use two bytes per pixel, "...p" one stream of bits, and "...Packed" GigE
/// Vision's three bytes for two pixels.
enum class PixelFormat {
  kMono8,
  kMono10,
  kMono10p,
  kMono10Packed,
  kMono12,
  kMono12p,
  kMono12Packed
};

constexpr Named<PixelFormat> kPixelFormats[] = {{PixelFormat::kMono8, "Mono8"},
                                                {PixelFormat::kMono10, "Mono10"},
                                                {PixelFormat::kMono10p, "Mono10p"},
                                                {PixelFormat::kMono10Packed, "Mono10Packed"},
                                                {PixelFormat::kMono12, "Mono12"},
                                                {PixelFormat::kMono12p, "Mono12p"},
                                                {PixelFormat::kMono12Packed, "Mono12Packed"}};

/// Returns the bytes that `pixels` pixels take.
std::size_t bytes_of(PixelFormat format, std::size_t pixels);

/// Returns the upper eight bits of every pixel, CV_8UC1. The rows of `data` are not padded.
cv::Mat unpack(PixelFormat format, const std::uint8_t* data, cv::Size size);

/// An output of the camera that switches the lamps on while it exposes.
struct CameraStrobe {
  std::string line;        ///< by its name in the camera, such as "Line1"
  double delay_s{0.0};     ///< from the beginning of the exposure
  double duration_s{0.0};  ///< 0: as long as the exposure
};

enum class CameraTrigger {
  kFreeRun,   ///< the camera exposes at its frame rate
  kSoftware,  ///< a command starts each exposure
  kHardware,  ///< an input line starts each exposure
};

/// Settings of a GigE Vision or USB3 Vision camera, applied at every opening.
struct AravisSettings {
  std::string address;  ///< of a GigE camera; empty for USB
  std::string id;       ///< serial number; empty for the first that answers
  cv::Size sensor_px;
  double frame_rate_hz{0.0};  ///< frames come at least at this rate, or the camera is at fault
  double exposure_s{0.0};
  double gain_db{0.0};
  PixelFormat pixel_format{PixelFormat::kMono8};
  CameraTrigger trigger{CameraTrigger::kFreeRun};
  std::optional<CameraStrobe> strobe{};
  int packet_size{0};  ///< bytes of a GigE packet; 0 for the largest that passes
  double timeout_s{0.5};
};

/// Throws InputError naming every setting that no camera can have.
void require_settings(const AravisSettings& settings);

/// Returns a message that says why this exposure time does not fit the frame rate.
std::string exposure_too_long(double exposure_s, double frame_rate_hz);

/// The port by which frames reach this machine, as the kernel describes it.
struct CameraPath {
  std::string port;                     ///< "eth0", "/dev/bus/usb/002/003"
  std::optional<int> mtu_bytes{};       ///< of a network interface
  std::optional<double> speed_bit_s{};  ///< unknown for a wireless network
  /// Of a network card, as far as it tells: its ring of packets, now and at most, how long it
  /// gathers packets before it interrupts, and what a socket may hold at most.
  std::optional<int> ring{}, ring_most{}, gathers_us{};
  std::optional<double> socket_bytes{};
  bool permitted{true};  ///< for USB, whether this user may open the device
};

/// Returns this machine's address from which `address` is reached, without any broadcast. Throws
/// InputError unless `address` is an IPv4 address, and WorkError when no network leads there.
std::string local_address_towards(const std::string& address);

/// Returns the network interface towards a GigE camera; throws like local_address_towards().
CameraPath find_network_path(const std::string& address, const std::filesystem::path& sys = "/sys");

/// Returns the port of the USB camera with this serial number, or of the first one when `serial` is
/// empty; empty when there is none.
std::optional<CameraPath> find_usb_path(const std::string& serial,
                                        const std::filesystem::path& sys = "/sys",
                                        const std::filesystem::path& dev = "/dev");

}  // namespace planar
