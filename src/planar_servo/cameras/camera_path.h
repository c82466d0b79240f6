#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace planar {

/// The port by which frames reach this machine, as the kernel describes it.
struct CameraPath {
  std::string port;                     ///< "eth0", "/dev/bus/usb/002/003"
  std::optional<int> mtu_bytes{};       ///< of a network interface
  std::optional<double> speed_bit_s{};  ///< unknown for a wireless network
  bool permitted{true};                 ///< for USB, whether this user may open the device
};

/// Returns this machine's address from which `address` is reached, without any broadcast. Throws
/// InputError unless `address` is an IPv4 address, and WorkError when no network leads there.
std::string local_address_towards(const std::string& address);

/// Returns the network interface towards a GigE camera; throws like local_address_towards(). `sys`
/// is where sysfs is mounted.
CameraPath find_network_path(const std::string& address, const std::filesystem::path& sys = "/sys");

/// Returns the port of the USB camera with this serial number, or of the first one when `serial` is
/// empty; empty when there is none.
std::optional<CameraPath> find_usb_path(const std::string& serial,
                                        const std::filesystem::path& sys = "/sys",
                                        const std::filesystem::path& dev = "/dev");

}  // namespace planar
