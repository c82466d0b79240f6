#include "planar_servo/hardware/cameras/aravis_settings.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// A device as /sys shows it.
void plug(const test::TemporaryFolder& sys, const std::string& name, const std::string& serial,
          const std::string& interface_class) {
  const std::string device = "bus/usb/devices/" + name;
  fs::create_directories(sys.path() / device / (name + ":1.0"));
  sys.write(device + "/busnum", "2\n");
  sys.write(device + "/devnum", "7\n");
  sys.write(device + "/speed", "5000\n");
  sys.write(device + "/serial", serial + "\n");
  sys.write(device + "/" + name + ":1.0/bInterfaceClass", interface_class + "\n");
  sys.write(device + "/" + name + ":1.0/bInterfaceSubClass", "05\n");
}

TEST_CASE("A USB camera is found by its serial number or by what it is") {
  const test::TemporaryFolder sys, dev;
  plug(sys, "2-1", "MOUSE", "03");
  plug(sys, "2-2", "CAMERA", "ef");
  for (const char* serial : {"", "CAMERA"}) {
    const auto path = find_usb_path(serial, sys.path(), dev.path());
    REQUIRE(path);
    CHECK(path->port == (dev.path() / "bus/usb/002/007").string());
    CHECK(path->speed_bit_s == 5e9);
    CHECK_FALSE(path->permitted);  // there is no node to be opened
  }
  fs::create_directories(dev.path() / "bus/usb/002");
  dev.write("bus/usb/002/007", "");
  CHECK(find_usb_path("CAMERA", sys.path(), dev.path())->permitted);
  CHECK_FALSE(find_usb_path("OTHER", sys.path(), dev.path()));
  CHECK_FALSE(find_usb_path("", dev.path(), dev.path()));
}

TEST_CASE("The network towards an address is found with its packets and its speed") {
  const test::TemporaryFolder sys;
  fs::create_directories(sys.path() / "class/net/lo");
  sys.write("class/net/lo/mtu", "9000\n");
  sys.write("class/net/lo/speed", "-1\n");
  const CameraPath loopback = find_network_path("127.0.0.1", sys.path());
  CHECK(loopback.port == "lo");
  CHECK(loopback.mtu_bytes == 9000);
  CHECK_FALSE(loopback.speed_bit_s);
  sys.write("class/net/lo/speed", "1000\n");
  CHECK(find_network_path("127.0.0.1", sys.path()).speed_bit_s == 1e9);
  CHECK_THROWS_AS(find_network_path("camera", sys.path()), InputError);
}

}  // namespace
}  // namespace planar
