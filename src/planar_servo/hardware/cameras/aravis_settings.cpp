#include "planar_servo/hardware/cameras/aravis_settings.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

/// The layout of the pixels of a format.
enum class Packing { kBits, kWords, kThreeBytes };
struct Layout {
  int bits;  ///< of a pixel
  Packing packing;
};
/// By PixelFormat.
constexpr Layout kLayouts[] = {{8, Packing::kBits},       {10, Packing::kWords},
                               {10, Packing::kBits},      {10, Packing::kThreeBytes},
                               {12, Packing::kWords},     {12, Packing::kBits},
                               {12, Packing::kThreeBytes}};

const Layout& layout_of(PixelFormat format) {
  return kLayouts[static_cast<std::size_t>(format)];
}

/// Unpacks pixels of two little-endian bytes, of which the lower `bits` bits are used.
void unpack_words(const std::uint8_t* data, int bits, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    pixels[i] = static_cast<std::uint8_t>((data[2 * i] | data[2 * i + 1] << 8) >> (bits - 8));
}

/// Unpacks pixels that form one stream of bits, the least significant bit first.
void unpack_bits(const std::uint8_t* data, int bits, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t upper = (i + 1) * static_cast<std::size_t>(bits) - 8;  // its first bit
    const std::uint8_t* byte = data + upper / 8;
    const unsigned shift = upper % 8;
    const unsigned next = shift == 0 ? 0U : byte[1];
    pixels[i] = static_cast<std::uint8_t>((byte[0] | next << 8) >> shift);
  }
}

/// Unpacks three bytes for two pixels: the upper eight bits of each, with their lower bits between.
void unpack_packed(const std::uint8_t* data, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) pixels[i] = data[i / 2 * 3 + (i % 2) * 2];
}

}  // namespace

std::size_t bytes_of(PixelFormat format, std::size_t pixels) {
  const Layout& layout = layout_of(format);
  if (layout.packing == Packing::kWords) return 2 * pixels;
  const int bits = layout.packing == Packing::kThreeBytes ? 12 : layout.bits;
  return (static_cast<std::size_t>(bits) * pixels + 7) / 8;
}

cv::Mat unpack(PixelFormat format, const std::uint8_t* data, cv::Size size) {
  cv::Mat image(size, CV_8UC1);
  const std::size_t n = image.total();
  const auto [bits, packing] = layout_of(format);
  if (format == PixelFormat::kMono8)
    std::memcpy(image.data, data, n);
  else if (packing == Packing::kWords)
    unpack_words(data, bits, image.data, n);
  else if (packing == Packing::kBits)
    unpack_bits(data, bits, image.data, n);
  else
    unpack_packed(data, image.data, n);
  return image;
}

void require_settings(const AravisSettings& settings) {
  Faults faults;
  const auto require = [&](bool holds, const std::string& rule) {
    if (!holds) faults.add({rule, "", "camera settings"});
  };
  require(!settings.sensor_px.empty(), "the sensor needs pixels");
  require(settings.frame_rate_hz > 0.0, "the frame rate must be positive");
  require(settings.exposure_s > 0.0, "the exposure time must be positive");
  require(settings.exposure_s * settings.frame_rate_hz < 1.0,
          exposure_too_long(settings.exposure_s, settings.frame_rate_hz));
  require(settings.timeout_s > 0.0, "the timeout must be positive");
  faults.throw_if_any();
}

std::string exposure_too_long(double exposure_s, double frame_rate_hz) {
  return fmt::format("an exposure of {:.0f} us does not fit into a period at {:.3g} Hz",
                     1e6 * exposure_s, frame_rate_hz);
}

namespace {

namespace fs = std::filesystem;

constexpr std::uint16_t kGvcpPort = 3956;
constexpr double kMegabit = 1e6;
/// An interface's class "miscellaneous" and subclass "USB3 Vision" [USB3 Vision 1.0, section 3].
constexpr char kVisionClass[] = "ef", kVisionSubClass[] = "05";

template <typename Value>
std::optional<Value> read_value(const fs::path& file) {
  Value value;
  if (!(std::ifstream(file) >> value)) return std::nullopt;
  return value;
}

std::string text_of(const sockaddr* address) {
  char text[INET_ADDRSTRLEN];
  return inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text,
                   sizeof(text));
}

std::string interface_with(const std::string& local_address) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0)
    throw WorkError("this machine does not list its network interfaces", Cause::kSystem);
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> all(first, freeifaddrs);
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next)
    if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET &&
        text_of(one->ifa_addr) == local_address)
      return one->ifa_name;
  throw WorkError("no network interface has the address " + local_address, Cause::kSystem);
}

std::vector<fs::path> folders_in(const fs::path& parent) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(parent, ignored)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// Fills in one of the structs that a network card's driver answers by [linux/ethtool.h].
template <typename Answer>
bool ask_card(const std::string& interface, Answer& answer) {
  ifreq request{};
  interface.copy(request.ifr_name, sizeof(request.ifr_name) - 1);
  request.ifr_data = reinterpret_cast<char*>(&answer);
  const int socket_of_any_kind = socket(AF_INET, SOCK_DGRAM, 0);
  const bool answered =
      socket_of_any_kind >= 0 && ioctl(socket_of_any_kind, SIOCETHTOOL, &request) == 0;
  if (socket_of_any_kind >= 0) close(socket_of_any_kind);
  return answered;
}

void ask_card(CameraPath& path) {
  ethtool_ringparam ring{};
  ring.cmd = ETHTOOL_GRINGPARAM;
  if (ask_card(path.port, ring) && ring.rx_max_pending > 0) {
    path.ring = static_cast<int>(ring.rx_pending);
    path.ring_most = static_cast<int>(ring.rx_max_pending);
  }
  ethtool_coalesce gathering{};
  gathering.cmd = ETHTOOL_GCOALESCE;
  if (ask_card(path.port, gathering) && gathering.use_adaptive_rx_coalesce == 0)
    path.gathers_us = static_cast<int>(gathering.rx_coalesce_usecs);
}

bool is_camera(const fs::path& device) {
  for (const fs::path& part : folders_in(device))
    if (read_value<std::string>(part / "bInterfaceClass") == kVisionClass &&
        read_value<std::string>(part / "bInterfaceSubClass") == kVisionSubClass)
      return true;
  return false;
}

}  // namespace

std::string local_address_towards(const std::string& address) {
  sockaddr_in remote{};
  remote.sin_family = AF_INET;
  remote.sin_port = htons(kGvcpPort);
  if (inet_pton(AF_INET, address.c_str(), &remote.sin_addr) != 1)
    throw InputError("the camera's address '" + address +
                     "' is not an IPv4 address such as 192.168.0.2");
  sockaddr_in local{};
  socklen_t size = sizeof(local);
  const int probe = socket(AF_INET, SOCK_DGRAM, 0);  // connecting a datagram socket sends nothing
  const bool found = probe >= 0 &&
                     connect(probe, reinterpret_cast<sockaddr*>(&remote), sizeof(remote)) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&local), &size) == 0;
  if (probe >= 0) close(probe);
  if (!found)
    throw WorkError(
        {"no network leads to the camera at " + address,
         "give this machine an address in the camera's network (ip route get " + address + ")", "",
         Cause::kSystem});
  return text_of(reinterpret_cast<const sockaddr*>(&local));
}

CameraPath find_network_path(const std::string& address, const fs::path& sys) {
  CameraPath path{interface_with(local_address_towards(address))};
  const fs::path interface = sys / "class/net" / path.port;
  path.mtu_bytes = read_value<int>(interface / "mtu");
  const auto speed_mbit = read_value<double>(interface / "speed");
  if (speed_mbit && *speed_mbit > 0.0) path.speed_bit_s = kMegabit * *speed_mbit;
  path.socket_bytes = read_value<double>("/proc/sys/net/core/rmem_max");
  ask_card(path);
  return path;
}

std::optional<CameraPath> find_usb_path(const std::string& serial, const fs::path& sys,
                                        const fs::path& dev) {
  for (const fs::path& device : folders_in(sys / "bus/usb/devices")) {
    const auto bus = read_value<int>(device / "busnum"),
               number = read_value<int>(device / "devnum");
    const bool wanted =
        serial.empty() ? is_camera(device) : read_value<std::string>(device / "serial") == serial;
    if (!bus || !number || !wanted) continue;
    CameraPath path{dev / fmt::format("bus/usb/{:03}/{:03}", *bus, *number)};
    path.permitted = access(path.port.c_str(), R_OK | W_OK) == 0;
    if (const auto speed_mbit = read_value<double>(device / "speed"))
      path.speed_bit_s = kMegabit * *speed_mbit;
    return path;
  }
  return std::nullopt;
}

}  // namespace planar
