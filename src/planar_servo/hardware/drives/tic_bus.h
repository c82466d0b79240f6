#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"

struct libusb_context;
struct libusb_device_handle;

namespace planar {

/// Requests, settings and units of the Pololu Tic over USB [Pololu, Tic Stepper Motor Controller
/// User's Guide, sections 5 to 8 and 11].
namespace tic {

constexpr std::uint16_t kVendor = 0x1ffb;

enum class Command : std::uint8_t {
  kReinitialize = 0x10,
  kSetSetting = 0x13,
  kExitSafeStart = 0x83,
  kEnergize = 0x85,
  kHaltAndHold = 0x89,
  kClearDriverError = 0x8a,
  kResetCommandTimeout = 0x8c,
  kEnterSafeStart = 0x8f,
  kGoHome = 0x97,
  kGetVariables = 0xa1,
  kGetVariablesAndClearErrors = 0xa2,  ///< those that have occurred
  kGetSettings = 0xa8,
  kSetTargetPosition = 0xe0,
  kSetMaxSpeed = 0xe6,
  kSetMaxDeceleration = 0xe9,
  kSetMaxAcceleration = 0xea,
  kHaltAndSetPosition = 0xec,
};

/// Offsets of settings, which outlast a power cycle.
enum Setting : std::uint8_t {
  kControlMode = 0x01,
  kDisableSafeStart = 0x03,
  kCommandTimeoutMs = 0x09,  ///< two bytes
  kSoftErrorResponse = 0x53,
  kForwardLimitPins = 0x5f,
  kReverseLimitPins = 0x60,
};

constexpr std::uint8_t kControlModeUsb = 0;
constexpr std::uint8_t kResponseHaltAndHold = 1;
constexpr std::uint16_t kOldestFirmware = 0x0106;  ///< the first version that can home
constexpr double kMaxSpeed = 50e3;                 ///< pulses/s

/// Convert to the drive's units: pulses per 10 000 s, and pulses/s per 100 s. Throw InputError,
/// which names the bounds, for values beyond them and for NaN.
std::uint32_t speed_units(double speed_pulses_s);
std::uint32_t acceleration_units(double acceleration_pulses_s2);

/// Number of bytes from the first setting to the last one that is read.
constexpr std::size_t kSettingsBytes = 0x61;

/// Returns why a drive with this firmware and these settings cannot be used; empty when it can.
std::optional<Refusal> unfitness(std::uint16_t firmware, const std::vector<std::uint8_t>& settings);

/// Returns the product's name, such as "Tic 36v4"; empty for products that are not Tics.
std::string product_name(std::uint16_t product_id);
/// Writes binary coded decimal as a version: 0x0109 is "1.09".
std::string firmware_name(std::uint16_t bcd);

/// The first variables of a Tic: all that a servo cycle needs.
class StatusBlock {
 public:
  static constexpr std::size_t kBytes = 0x35;
  using Bytes = std::array<std::uint8_t, kBytes>;

  explicit StatusBlock(const Bytes& bytes) : bytes_(bytes) {}

  std::int32_t position() const { return read<std::int32_t>(0x22); }
  bool ready() const { return bytes_[0x00] == kNormal && flag(kEnergized); }
  bool position_certain() const { return !flag(kPositionUncertain); }
  bool homing() const { return flag(kHoming); }
  double supply_v() const { return read<std::uint16_t>(0x33) * 1e-3; }

  /// Returns the target position, or the present one unless a position was commanded.
  std::int32_t target() const;
  bool moving() const;
  /// Returns the errors that keep the drive from moving, stops by hand that have passed since they
  /// were cleared, and a limit switch in its way.
  std::vector<std::string> faults() const;
  /// Returns the errors that switching on does not clear.
  std::vector<std::string> standing_faults() const;
  DriveStatus drive_status() const;

 private:
  enum Flag { kEnergized, kPositionUncertain, kForwardLimit, kReverseLimit, kHoming };
  static constexpr std::uint8_t kNormal = 10;
  static constexpr std::uint8_t kToPosition = 1;  ///< planning mode

  template <typename T>
  T read(std::size_t offset) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value |= static_cast<std::uint32_t>(bytes_[offset + i]) << (8 * i);
    return static_cast<T>(value);
  }
  bool flag(Flag bit) const { return (bytes_[0x01] >> bit & 1) != 0; }
  unsigned errors() const { return read<std::uint16_t>(0x02); }
  unsigned occurred() const { return read<std::uint32_t>(0x04); }
  bool limit_in_the_way() const;

  Bytes bytes_;
};

}  // namespace tic

/// A Tic that is plugged in.
struct TicListing {
  std::string serial;
  std::uint16_t product_id{0};
  std::uint16_t firmware{0};  ///< binary coded decimal
  std::string device;         ///< "/dev/bus/usb/001/004"
};

/// An opened Tic. No other process can use it until it is closed.
struct TicPort {
  TicListing listing;
  std::unique_ptr<libusb_device_handle, void (*)(libusb_device_handle*)> handle;
};

/// One control transfer and its outcome.
struct TicTransfer {
  TicPort* port{nullptr};  ///< if null, nothing is transferred
  tic::Command command{tic::Command::kResetCommandTimeout};
  std::uint32_t value{0};            ///< lower half: the transfer's value; upper half: its index
  std::vector<std::uint8_t> data{};  ///< sized to the bytes that are to be read
  std::string error{};               ///< in words; empty on success
  bool lost{false};                  ///< whether the device has left the bus
};

/// Gives access to the Tics on the USB bus. After construction nothing here throws but bad_alloc.
class TicBus {
 public:
  /// Throws WorkError when this machine has no USB.
  TicBus();
  ~TicBus();
  TicBus(const TicBus&) = delete;
  TicBus& operator=(const TicBus&) = delete;

  /// Opens the Tic with this serial number. Returns null when that fails, with the reason in `why`.
  std::unique_ptr<TicPort> open(const std::string& serial, Refusal& why);

  /// Runs all transfers and waits until each has ended or timed out. Transfers to one device run in
  /// order, those to different devices at the same time.
  void exchange(std::vector<TicTransfer>& transfers, double timeout_s);

 private:
  libusb_context* context_{nullptr};
};

}  // namespace planar
