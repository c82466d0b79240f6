#include "planar_servo/drives/tic/tic_bus.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr std::uint8_t kVendorOut = 0x40;
constexpr std::uint8_t kVendorIn = 0xc0;
constexpr int kInterface = 0;

/// Holds the list of plugged-in devices while it is looked at.
class DeviceList {
 public:
  explicit DeviceList(libusb_context* context)
      : count_(libusb_get_device_list(context, &devices_)) {}
  ~DeviceList() {
    if (count_ >= 0) libusb_free_device_list(devices_, 1);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;

  libusb_device** begin() const { return devices_; }
  libusb_device** end() const { return devices_ + std::max<ssize_t>(count_, 0); }

 private:
  libusb_device** devices_{nullptr};
  ssize_t count_;
};

/// Returns whether the device is a Tic, and fills in what can be told without opening it.
bool describe(libusb_device* device, TicListing& listing, std::uint8_t& serial_string) {
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != 0) return false;
  if (descriptor.idVendor != tic::kVendor || tic::product_name(descriptor.idProduct).empty())
    return false;
  listing.product_id = descriptor.idProduct;
  listing.firmware = descriptor.bcdDevice;
  listing.device = fmt::format("/dev/bus/usb/{:03}/{:03}", libusb_get_bus_number(device),
                               libusb_get_device_address(device));
  serial_string = descriptor.iSerialNumber;
  return true;
}

Refusal refusal_of(int error, const std::string& device) {
  if (error == LIBUSB_ERROR_ACCESS)
    return {
        device + " may not be opened",
        "install the udev rules of planar-servo (sudo cmake --install build/release), then plug "
        "the drive in again"};
  if (error == LIBUSB_ERROR_BUSY)
    return {device + " is in use by another program", "end that program"};
  return {fmt::format("{} cannot be opened: {}", device, libusb_strerror(error))};
}

std::string read_serial(libusb_device_handle* handle, std::uint8_t number) {
  std::array<unsigned char, 128> text{};
  const int size = libusb_get_string_descriptor_ascii(handle, number, text.data(), text.size());
  return std::string(text.begin(), text.begin() + std::max(size, 0));
}

std::string words_of(libusb_transfer_status status, double timeout_s) {
  switch (status) {
    case LIBUSB_TRANSFER_TIMED_OUT:
      return fmt::format("it does not answer within {:.0f} ms", timeout_s * 1e3);
    case LIBUSB_TRANSFER_STALL:
      return "it refuses the request (stalled transfer)";
    case LIBUSB_TRANSFER_NO_DEVICE:
      return "it is unplugged";
    default:
      return "the USB transfer failed (check cable and hub)";
  }
}

/// A running transfer in libusb's form.
struct UnderWay {
  UnderWay() : transfer(libusb_alloc_transfer(0)) {}
  ~UnderWay() { libusb_free_transfer(transfer); }
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;

  libusb_transfer* transfer;
  std::vector<unsigned char> buffer;
  int completed{0};
};

void LIBUSB_CALL note_completion(libusb_transfer* transfer) {
  *static_cast<int*>(transfer->user_data) = 1;
}

/// Copies what libusb has delivered into `request`, or the reason why it has not.
void take_outcome(const UnderWay& done, double timeout_s, TicTransfer& request) {
  const libusb_transfer& transfer = *done.transfer;
  if (transfer.status != LIBUSB_TRANSFER_COMPLETED) {
    request.error = words_of(transfer.status, timeout_s);
    request.lost = transfer.status == LIBUSB_TRANSFER_NO_DEVICE;
  } else if (transfer.actual_length != static_cast<int>(request.data.size())) {
    request.error =
        fmt::format("it sent {} bytes instead of {}", transfer.actual_length, request.data.size());
  } else {
    std::copy_n(done.buffer.begin() + LIBUSB_CONTROL_SETUP_SIZE, request.data.size(),
                request.data.begin());
  }
}

}  // namespace

TicPort::~TicPort() {
  libusb_release_interface(handle_, kInterface);
  libusb_close(handle_);
}

TicBus::TicBus() {
  const int error = libusb_init(&context_);
  if (error != 0)
    throw WorkError(fmt::format("USB cannot be used on this machine: {}", libusb_strerror(error)));
}

TicBus::~TicBus() {
  libusb_exit(context_);
}

std::unique_ptr<TicPort> TicBus::open(const std::string& serial, Refusal& why) {
  std::vector<std::string> others;
  why.remedy = "plug it in and give it power, or correct its number in the cell file";
  for (libusb_device* device : DeviceList(context_)) {
    TicListing listing;
    std::uint8_t serial_string = 0;
    if (!describe(device, listing, serial_string)) continue;
    libusb_device_handle* handle = nullptr;
    int error = libusb_open(device, &handle);
    if (error == 0) {
      listing.serial = read_serial(handle, serial_string);
      if (listing.serial == serial) error = libusb_claim_interface(handle, kInterface);
      if (listing.serial == serial && error == 0)
        return std::unique_ptr<TicPort>(new TicPort(handle, std::move(listing)));
      libusb_close(handle);
    }
    const Refusal refusal = refusal_of(error, listing.device);
    others.push_back(error == 0 ? listing.serial : refusal.fault);
    if (error != 0 && !refusal.remedy.empty()) why.remedy = refusal.remedy;
  }
  why.fault =
      fmt::format("no Tic with the serial number '{}' can be opened (plugged in: {})", serial,
                  others.empty() ? "none" : fmt::format("{}", fmt::join(others, ", ")));
  return nullptr;
}

void TicBus::exchange(std::vector<TicTransfer>& transfers, double timeout_s) {
  std::vector<UnderWay> under_way(transfers.size());
  for (std::size_t i = 0; i < transfers.size(); ++i) {
    TicTransfer& request = transfers[i];
    UnderWay& running = under_way[i];
    if (request.port == nullptr) continue;
    const auto length = static_cast<std::uint16_t>(request.data.size());
    running.buffer.resize(LIBUSB_CONTROL_SETUP_SIZE + length);
    libusb_fill_control_setup(running.buffer.data(), length > 0 ? kVendorIn : kVendorOut,
                              static_cast<std::uint8_t>(request.command), request.value,
                              request.index, length);
    libusb_fill_control_transfer(running.transfer, request.port->handle_, running.buffer.data(),
                                 note_completion, &running.completed,
                                 static_cast<unsigned>(std::ceil(timeout_s * 1e3)));
    if (const int error = libusb_submit_transfer(running.transfer)) {
      running.completed = 1;
      running.transfer->status =
          error == LIBUSB_ERROR_NO_DEVICE ? LIBUSB_TRANSFER_NO_DEVICE : LIBUSB_TRANSFER_ERROR;
    }
  }
  for (std::size_t i = 0; i < transfers.size(); ++i) {
    if (transfers[i].port == nullptr) continue;
    while (under_way[i].completed == 0)
      libusb_handle_events_completed(context_, &under_way[i].completed);
    take_outcome(under_way[i], timeout_s, transfers[i]);
  }
}

}  // namespace planar
