#include "planar_servo/hardware/drives/tic_bus.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar::tic {
namespace {

constexpr double kSpeedUnits = 1e4;         // per pulse/s
constexpr double kAccelerationUnits = 1e2;  // per pulse/s^2
constexpr double kMaxAcceleration = 0x7fffffff / kAccelerationUnits;
constexpr double kMinSpeed = 7 / kSpeedUnits;  // a Tic treats 1 to 6 units as 0
constexpr double kMinAcceleration = 1.0;

/// Names the bits of the error status. Bit 0 means that the motor is off, which is no fault.
constexpr std::array<const char*, 9> kErrors{nullptr,
                                             "motor driver error",
                                             "low supply voltage",
                                             "kill switch active",
                                             "required input invalid",
                                             "serial error",
                                             "command timeout",
                                             "safe start: it has to be switched on again",
                                             "its ERR line is high"};

constexpr Named<std::uint16_t> kProducts[] = {{0x00b3, "Tic T825"}, {0x00b5, "Tic T834"},
                                              {0x00bd, "Tic T500"}, {0x00c3, "Tic N825"},
                                              {0x00c9, "Tic T249"}, {0x00cb, "Tic 36v4"}};

/// The bits for low supply, as where an emergency stop cuts the motors' power, and kill switch.
constexpr unsigned kStoppedByHand = 1U << 2 | 1U << 3;
/// The bits for driver error, serial error, command timeout and safe start.
constexpr unsigned kClearedByCommands = 1U << 1 | 1U << 5 | 1U << 6 | 1U << 7;

std::vector<std::string> error_names(unsigned errors) {
  std::vector<std::string> names;
  for (std::size_t bit = 1; bit < kErrors.size(); ++bit)
    if (errors >> bit & 1) names.emplace_back(kErrors[bit]);
  return names;
}

std::uint32_t in_units(const char* what, double value, double lower, double upper, double units) {
  if (!(value >= lower && value <= upper))
    throw InputError({fmt::format("a Tic's {} is {} pulses", what, value),
                      fmt::format("it can be from {} to {}", lower, upper)});
  return static_cast<std::uint32_t>(std::llround(value * units));
}

}  // namespace

std::uint32_t speed_units(double speed_pulses_s) {
  return in_units("speed per second", speed_pulses_s, kMinSpeed, kMaxSpeed, kSpeedUnits);
}

std::uint32_t acceleration_units(double acceleration_pulses_s2) {
  return in_units("acceleration per second squared", acceleration_pulses_s2, kMinAcceleration,
                  kMaxAcceleration, kAccelerationUnits);
}

std::optional<Refusal> unfitness(std::uint16_t firmware,
                                 const std::vector<std::uint8_t>& settings) {
  if (firmware < kOldestFirmware)
    return Refusal{fmt::format("its firmware {} is too old", firmware_name(firmware)),
                   fmt::format("upgrade it to {} or later with Pololu's Tic Control Center",
                               firmware_name(kOldestFirmware)),
                   "", Cause::kForeign};
  if (settings.at(kControlMode) != kControlModeUsb)
    return Refusal{fmt::format("its control mode is {}, in which it ignores this program",
                               settings.at(kControlMode)),
                   "set it to 'Serial / I2C / USB' in Pololu's Tic Control Center", "",
                   Cause::kDevice};
  if (settings.at(kDisableSafeStart) != 0)
    return Refusal{"its safe start is disabled, so that it could move by surprise",
                   "enable it in Pololu's Tic Control Center", "", Cause::kDevice};
  return std::nullopt;
}

std::string product_name(std::uint16_t product_id) {
  for (const auto& [known, name] : kProducts)
    if (known == product_id) return name;
  return "";
}

std::string firmware_name(std::uint16_t bcd) {
  return fmt::format("{:x}.{:02x}", bcd >> 8, bcd & 0xff);
}

std::int32_t StatusBlock::target() const {
  return bytes_[0x09] == kToPosition ? read<std::int32_t>(0x0a) : position();
}

bool StatusBlock::limit_in_the_way() const {
  return (flag(kForwardLimit) && target() > position()) ||
         (flag(kReverseLimit) && target() < position());
}

bool StatusBlock::moving() const {
  const auto velocity = read<std::int32_t>(0x26);
  return velocity != 0 || homing() || (target() != position() && !limit_in_the_way());
}

std::vector<std::string> StatusBlock::standing_faults() const {
  return error_names(errors() & ~kClearedByCommands);
}

std::vector<std::string> StatusBlock::faults() const {
  std::vector<std::string> faults = error_names(errors());
  for (const std::string& passed : error_names(occurred() & kStoppedByHand & ~errors()))
    faults.push_back(passed + " for a moment");
  if (limit_in_the_way() && !homing())
    faults.emplace_back(flag(kForwardLimit) ? "it stands on its forward limit switch"
                                            : "it stands on its reverse limit switch");
  return faults;
}

DriveStatus StatusBlock::drive_status() const {
  DriveStatus status;
  status.position_pulses = position();
  status.target_pulses = target();
  status.energized = ready();
  status.moving = moving();
  status.position_certain = position_certain();
  status.homing = homing();
  status.faults = faults();
  status.stopped_by_hand = ((errors() | occurred()) & kStoppedByHand) != 0;
  return status;
}

}  // namespace planar::tic

namespace planar {
namespace {

constexpr std::uint8_t kVendorOut = 0x40;
constexpr std::uint8_t kVendorIn = 0xc0;
constexpr int kInterface = 0;

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
    return {device + " may not be opened",
            fmt::format("{}, then plug the drive in again", kInstallRules), "", Cause::kSystem};
  if (error == LIBUSB_ERROR_BUSY)
    return {device + " is in use by another program", "end that program", "", Cause::kBusy};
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

void close_port(libusb_device_handle* handle) {
  libusb_release_interface(handle, kInterface);
  libusb_close(handle);
}

/// A running transfer in libusb's form.
struct UnderWay {
  std::unique_ptr<libusb_transfer, void (*)(libusb_transfer*)> transfer{libusb_alloc_transfer(0),
                                                                        libusb_free_transfer};
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

TicBus::TicBus() {
  const int error = libusb_init(&context_);
  if (error != 0)
    throw WorkError(fmt::format("USB cannot be used on this machine: {}", libusb_strerror(error)),
                    Cause::kSystem);
}

TicBus::~TicBus() {
  libusb_exit(context_);
}

std::unique_ptr<TicPort> TicBus::open(const std::string& serial, Refusal& why) {
  std::vector<std::string> others;
  why = {"", "plug it in and give it power, or correct its number in the cell file", "",
         Cause::kMissing};
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context_, &devices);
  const AtEnd given_back([&] {
    if (count >= 0) libusb_free_device_list(devices, 1);
  });
  for (ssize_t i = 0; i < count; ++i) {
    TicListing listing;
    std::uint8_t serial_string = 0;
    if (!describe(devices[i], listing, serial_string)) continue;
    libusb_device_handle* handle = nullptr;
    int error = libusb_open(devices[i], &handle);
    if (error == 0) {
      listing.serial = read_serial(handle, serial_string);
      if (listing.serial == serial) error = libusb_claim_interface(handle, kInterface);
      if (listing.serial == serial && error == 0)
        return std::make_unique<TicPort>(TicPort{std::move(listing), {handle, close_port}});
      libusb_close(handle);
    }
    const Refusal refusal = refusal_of(error, listing.device);
    others.push_back(error == 0 ? listing.serial : refusal.fault);
    if (error != 0 && !refusal.remedy.empty()) why = refusal;
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
                              static_cast<std::uint8_t>(request.command),
                              static_cast<std::uint16_t>(request.value & 0xffff),
                              static_cast<std::uint16_t>(request.value >> 16), length);
    libusb_fill_control_transfer(running.transfer.get(), request.port->handle.get(),
                                 running.buffer.data(), note_completion, &running.completed,
                                 static_cast<unsigned>(std::ceil(timeout_s * 1e3)));
    if (const int error = libusb_submit_transfer(running.transfer.get())) {
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
