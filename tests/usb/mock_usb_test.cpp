#include "support/mock_usb.h"

#include <libusb.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>

#include "support/eventually.h"

namespace planar::test {
namespace {

constexpr std::uint16_t kVendor = 0x1ffb;
constexpr unsigned kPatience_ms = 2000;  // a busy machine answers within it
constexpr unsigned char kOut = 0x40;
constexpr unsigned char kIn = 0xc0;

/// Gives back over control and bulk transfers what it was told last.
class Echo final : public UsbFunction {
 public:
  UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) override {
    if (setup.request == 0x77) return {-EPIPE, 0};
    if (!setup.to_host()) {
      said_ = setup.value;
      return {0, setup.length};
    }
    std::memset(data, said_, setup.length);
    return {0, setup.length};
  }
  UsbOutcome bulk_out(int /*endpoint*/, const std::uint8_t* data, std::size_t size) override {
    bulk_.assign(data, data + size);
    return {0, size};
  }
  std::optional<UsbOutcome> bulk_in(int /*endpoint*/, std::uint8_t* data,
                                    std::size_t size) override {
    if (bulk_.empty()) return std::nullopt;
    const std::size_t sent = std::min(size, bulk_.size());
    std::copy_n(bulk_.begin(), sent, data);
    bulk_.clear();
    return UsbOutcome{0, sent};
  }

 private:
  int said_{0};
  std::vector<std::uint8_t> bulk_;
};

UsbDescription two_endpoints(const std::string& serial) {
  return {{18, 1, 0x00, 0x02, 0, 0, 0, 64, 0xfb, 0x1f, 0xcb, 0, 0x09, 0x01, 1, 2, 3, 1},
          {9, 2, 32, 0, 1,    1, 0,  0x80, 50, 9, 4, 0,    0, 2,  0xff, 0,
           0, 0, 7,  5, 0x01, 2, 64, 0,    0,  7, 5, 0x82, 2, 64, 0,    0},
          {"Maker", "Echo", serial},
          12};
}

struct Host {
  Host() { REQUIRE(libusb_init(&context) == 0); }
  ~Host() {
    if (handle != nullptr) libusb_close(handle);
    libusb_exit(context);
  }
  bool open() {
    if (handle != nullptr) libusb_close(handle);
    handle = libusb_open_device_with_vid_pid(context, kVendor, 0x00cb);
    return handle != nullptr && libusb_claim_interface(handle, 0) == 0;
  }
  int ask(std::uint8_t request = 1, int length = 4) {
    return libusb_control_transfer(handle, kIn, request, 0, 0, answer.data(),
                                   static_cast<std::uint16_t>(length), kPatience_ms);
  }

  libusb_context* context{nullptr};
  libusb_device_handle* handle{nullptr};
  std::array<unsigned char, 64> answer{};
};

struct Bench {
  MockUsbBus bus;
  Echo echo;
  MockUsbDevice device{bus, two_endpoints("E1"), echo};
  Host host;
};

}  // namespace

TEST_CASE("A device of the mock bus is found, read and written through libusb") {
  Bench bench;
  REQUIRE(bench.host.open());
  CHECK(libusb_control_transfer(bench.host.handle, kOut, 1, 42, 0, nullptr, 0, kPatience_ms) == 0);
  CHECK(bench.host.ask() == 4);
  CHECK(bench.host.answer[3] == 42);
  CHECK(libusb_get_string_descriptor_ascii(bench.host.handle, 3, bench.host.answer.data(), 64) ==
        2);
  CHECK(std::memcmp(bench.host.answer.data(), "E1", 2) == 0);
}

TEST_CASE("Bulk transfers to the host wait for data and come in order") {
  Bench bench;
  REQUIRE(bench.host.open());
  std::array<unsigned char, 3> sent{1, 2, 3};
  int moved = 0;
  CHECK(libusb_bulk_transfer(bench.host.handle, 0x82, bench.host.answer.data(), 64, &moved, 20) ==
        LIBUSB_ERROR_TIMEOUT);
  CHECK(libusb_bulk_transfer(bench.host.handle, 0x01, sent.data(), 3, &moved, kPatience_ms) == 0);
  CHECK(libusb_bulk_transfer(bench.host.handle, 0x82, bench.host.answer.data(), 64, &moved,
                             kPatience_ms) == 0);
  CHECK(moved == 3);
  CHECK(bench.host.answer[2] == 3);
}

TEST_CASE("Injected faults reach the host as the kernel would tell them") {
  Bench bench;
  REQUIRE(bench.host.open());
  bench.device.inject({UsbFault::Kind::kStall});
  CHECK(bench.host.ask() == LIBUSB_ERROR_PIPE);
  CHECK(bench.host.ask() == 4);
  bench.device.inject({UsbFault::Kind::kIoError});
  CHECK(bench.host.ask() == LIBUSB_ERROR_IO);
  UsbFault cut{UsbFault::Kind::kShort};
  cut.bytes = 2;
  bench.device.inject(cut);
  CHECK(bench.host.ask() == 2);
  UsbFault silence{UsbFault::Kind::kSilence, -1, std::uint8_t{1}};
  bench.device.inject(silence);
  CHECK(libusb_control_transfer(bench.host.handle, kIn, 1, 0, 0, bench.host.answer.data(), 4, 30) ==
        LIBUSB_ERROR_TIMEOUT);
  CHECK(bench.host.ask(2) == 4);  // the fault is of request 1
  bench.device.clear_fault();
  CHECK(bench.host.ask() == 4);
  CHECK(bench.host.ask(0x77) == LIBUSB_ERROR_PIPE);
}

TEST_CASE("A late answer is right, and late") {
  Bench bench;
  REQUIRE(bench.host.open());
  UsbFault late{UsbFault::Kind::kLate};
  late.late_s = 0.05;
  bench.device.inject(late);
  CHECK(libusb_control_transfer(bench.host.handle, kIn, 1, 0, 0, bench.host.answer.data(), 4, 10) ==
        LIBUSB_ERROR_TIMEOUT);
  bench.device.inject(late);
  CHECK(bench.host.ask() == 4);
}

TEST_CASE("Each opening of a device reaps its own transfers") {
  Bench bench;
  REQUIRE(bench.host.open());
  libusb_device_handle* again = nullptr;
  REQUIRE(libusb_open(libusb_get_device(bench.host.handle), &again) == 0);
  std::array<unsigned char, 4> answer{};
  for (int i = 0; i < 100; ++i) {
    CHECK(bench.host.ask() == 4);
    CHECK(libusb_control_transfer(again, kIn, 1, 0, 0, answer.data(), 4, kPatience_ms) == 4);
  }
  libusb_close(again);
}

TEST_CASE("An unplugged device is gone until it is plugged in again, at another address") {
  Bench bench;
  REQUIRE(bench.host.open());
  const int address = libusb_get_device_address(libusb_get_device(bench.host.handle));
  bench.device.unplug();
  CHECK(bench.host.ask() == LIBUSB_ERROR_NO_DEVICE);
  CHECK(eventually([&] { return !bench.host.open(); }));
  bench.device.plug();
  CHECK(eventually([&] { return bench.host.open(); }));
  CHECK(bench.host.ask() == 4);
  CHECK(libusb_get_device_address(libusb_get_device(bench.host.handle)) != address);
}

}  // namespace planar::test
