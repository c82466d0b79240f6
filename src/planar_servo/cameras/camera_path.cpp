#include "planar_servo/cameras/camera_path.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <vector>

#include "planar_servo/core/error.h"

namespace planar {
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
  if (getifaddrs(&first) != 0) throw WorkError("this machine does not tell its networks");
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> all(first, freeifaddrs);
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next)
    if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET &&
        text_of(one->ifa_addr) == local_address)
      return one->ifa_name;
  throw WorkError("no network has the address " + local_address);
}

std::vector<fs::path> folders_in(const fs::path& parent) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(parent, ignored)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
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
         "give this machine an address in the camera's network (ip route get " + address + ")"});
  return text_of(reinterpret_cast<const sockaddr*>(&local));
}

CameraPath find_network_path(const std::string& address, const fs::path& sys) {
  CameraPath path{interface_with(local_address_towards(address))};
  const fs::path interface = sys / "class/net" / path.port;
  path.mtu_bytes = read_value<int>(interface / "mtu");
  const auto speed_mbit = read_value<double>(interface / "speed");
  if (speed_mbit && *speed_mbit > 0.0) path.speed_bit_s = kMegabit * *speed_mbit;
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
