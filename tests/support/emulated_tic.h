#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "planar_servo/base/core/clock.h"
#include "support/mock_usb.h"

namespace planar::test {

/// A Pololu Tic 36v4 as it shows itself over USB, with a motor that turns in the time of a clock.
/// It has the operation states, safe start, command timeout, limit switches and homing of the Tic
/// user's guide (5.4 to 5.6, 7, 8, 11). It was written from that guide; the driver's protocol code
/// is not used. Two things are not known from the guide and are assumed: a limit switch that stops
/// the motor makes its position uncertain, and starting up takes 20 ms.
///
/// The shaft is what really turned. The position that the Tic counts differs from it after the Tic
/// was told another position or lost its power. Safe to use from any thread.
class EmulatedTic final : public UsbFunction {
 public:
  /// Is called with the shaft, in pulses, whenever it has turned.
  using OnPosition = std::function<void(std::int32_t shaft_pulses)>;

  /// Takes a clock, which must outlive it and allow calls from any thread. `on_position` may be
  /// empty; it must not call back.
  explicit EmulatedTic(const Clock& clock, OnPosition on_position = {});

  static constexpr std::uint16_t kProduct36v4 = 0x00cb;
  /// Returns the USB descriptors of a Tic. `firmware` is its version as binary-coded decimals.
  static UsbDescription description(const std::string& serial,
                                    std::uint16_t product_id = kProduct36v4,
                                    std::uint16_t firmware = 0x0109);

  UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) override;

  /// Lets the motor turn up to now and returns where the shaft is.
  std::int32_t shaft_pulses();
  /// Returns the clock's time at which the shaft turned last.
  double last_motion_s();
  /// Returns the number of position targets that it was sent, whether it obeyed or not.
  int targets_received();

  /// Places the switches: the shaft's pulses at which each closes. They are wired to pins that are
  /// set for them.
  void place_switches(std::optional<std::int32_t> reverse_at,
                      std::optional<std::int32_t> forward_at);
  /// Sets the speeds of a homing: towards the switch, and away from it afterwards.
  void set_homing_speeds(double towards_pulses_s, double away_pulses_s);
  /// Sets the voltage of the motor's supply.
  void set_supply(double volts);
  /// Closes or opens the kill switch.
  void press_kill_switch(bool pressed);
  /// Lets both supplies fail and come back. What is not stored is forgotten; the shaft stays.
  void power_cycle();
  /// Stores a setting as the maker's own software does. It takes effect at once.
  void store_setting(std::uint8_t offset, std::uint8_t value);
  /// Returns a stored setting.
  std::uint8_t setting(std::uint8_t offset);

 private:
  enum class Input { kHalt, kPosition, kVelocity };
  enum class Homing { kNone, kTowards, kPause, kAway };
  enum State : std::uint8_t {
    kReset = 0,
    kDeenergized = 2,
    kSoftError = 4,
    kStartingUp = 8,
    kNormal = 10
  };
  enum Error : unsigned {
    kIntentionallyDeenergized,
    kDriverError,
    kLowSupply,
    kKillSwitch,
    kCommandTimeout = 6,
    kSafeStart = 7
  };

  bool has(Error error) const { return (errors_ >> error & 1U) != 0; }
  void set(Error error, bool on);
  void advance();
  void step(double dt_s);
  void judge_state();
  void enter(State state);
  void move(double dt_s);
  void run_homing();
  double wanted_speed() const;
  bool blocked(double speed) const;
  bool switch_closed(bool forward) const;
  void halt_abruptly(bool uncertain);
  void halt_at_switch();
  void count_from(std::int32_t position);
  void boot();
  void load_settings();
  bool quick(std::uint8_t request, std::uint16_t value);
  bool word(std::uint8_t request, std::uint32_t value);
  std::array<std::uint8_t, 256> variables() const;
  std::uint32_t setting_of(std::uint8_t offset, int bytes) const;

  const Clock& clock_;
  OnPosition on_position_;
  std::mutex mutex_;
  std::array<std::uint8_t, 256> eeprom_{};
  std::array<std::uint8_t, 256> settings_{};  ///< the settings stored when it started last
  double now_s_;
  double boot_s_{0.0};

  double position_{0.0};       ///< counted pulses
  double offset_pulses_{0.0};  ///< the shaft's pulses minus the counted ones
  double speed_{0.0};          ///< pulses/s
  std::int32_t reported_shaft_{0};
  double last_motion_s_;
  std::optional<std::int32_t> reverse_at_, forward_at_;

  Input input_{Input::kHalt};
  std::int32_t target_position_{0}, target_velocity_{0};
  int targets_received_{0};
  std::uint32_t max_speed_{0}, max_acceleration_{0}, max_deceleration_{0}, starting_speed_{0};
  Homing homing_{Homing::kNone};
  bool homing_forward_{false};
  double homing_pause_until_s_{0.0};

  State state_{kReset};
  unsigned errors_{0}, errors_occurred_{0};
  bool uncertain_{true};
  bool deenergized_on_purpose_{true};
  bool kill_switch_{false};
  double supply_v_{24.0};
  double started_s_{0.0};  ///< time when it began to start up
  double safe_start_exit_until_s_{0.0};
  double last_command_s_{0.0};
  bool decelerates_to_hold_{false};
};

}  // namespace planar::test
