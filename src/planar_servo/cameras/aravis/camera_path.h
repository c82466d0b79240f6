#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace planar {

/// By what way frames come, as the kernel tells it.
struct CameraPath {
  std::string port;                     ///< "eth0", "/dev/bus/usb/002/003"
  std::optional<int> mtu_bytes{};       ///< of a network
  std::optional<double> speed_bit_s{};  ///< unknown of a network without a wire
  bool permitted{true};                 ///< USB: whether this user may open it
};

/// The address of ours from which `address` is reached, so that nothing needs to be broadcast.
/// Throws InputError when it is no address of IPv4, WorkError when no network leads there.
std::string local_address_towards(const std::string& address);

/// The network towards a GigE camera; throws as local_address_towards(). `sys` is where the kernel
/// tells of itself.
CameraPath find_network_path(const std::string& address, const std::filesystem::path& sys = "/sys");

/// Where the USB camera with this serial number is plugged in, or the first one when it is empty;
/// empty when there is none.
std::optional<CameraPath> find_usb_path(const std::string& serial,
                                        const std::filesystem::path& sys = "/sys",
                                        const std::filesystem::path& dev = "/dev");

}  // namespace planar
