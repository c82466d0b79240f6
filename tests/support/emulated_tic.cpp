#include "support/emulated_tic.h"

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace planar::test {
namespace {

constexpr double kStep_s = 2e-4;
constexpr double kSpeedUnits = 1e4;
constexpr double kAccelerationUnits = 1e2;
constexpr std::uint32_t kMaxSpeedUnits = 500000000;
constexpr double kStartUp_s = 0.02;
constexpr double kSafeStartExit_s = 0.2;
constexpr double kHomingPause_s = 0.02;
constexpr double kLowSupply_v = 5.0;

constexpr std::uint8_t kVendorOut = 0x40;
constexpr std::uint8_t kVendorIn = 0xc0;

// Settings
constexpr std::uint8_t kControlMode = 0x01;
constexpr std::uint8_t kDisableSafeStart = 0x03;
constexpr std::uint8_t kCommandTimeoutMs = 0x09;
constexpr std::uint8_t kStoredMaxSpeed = 0x47;
constexpr std::uint8_t kStoredMaxDeceleration = 0x4b;
constexpr std::uint8_t kStoredMaxAcceleration = 0x4f;
constexpr std::uint8_t kSoftErrorResponse = 0x53;
constexpr std::uint8_t kForwardPins = 0x5f;
constexpr std::uint8_t kReversePins = 0x60;
constexpr std::uint8_t kHomingSpeedTowards = 0x61;
constexpr std::uint8_t kHomingSpeedAway = 0x65;

// Soft error responses
constexpr std::uint8_t kDeenergize = 0;
constexpr std::uint8_t kHaltAndHold = 1;

void put(std::array<std::uint8_t, 256>& bytes, std::size_t offset, std::uint32_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes[offset + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace

EmulatedTic::EmulatedTic(const Clock& clock, OnPosition on_position)
    : clock_(clock),
      on_position_(std::move(on_position)),
      now_s_(clock.now_s()),
      last_motion_s_(now_s_) {
  put(eeprom_, kCommandTimeoutMs, 1000, 2);
  put(eeprom_, kStoredMaxSpeed, 2000000, 4);
  put(eeprom_, kStoredMaxAcceleration, 40000, 4);
  put(eeprom_, kSoftErrorResponse, 2, 1);
  put(eeprom_, kHomingSpeedTowards, 1000000, 4);
  put(eeprom_, kHomingSpeedAway, 1000000, 4);
  boot();
}

UsbDescription EmulatedTic::description(const std::string& serial, std::uint16_t product_id,
                                        std::uint16_t firmware) {
  const auto low = [](std::uint16_t word) { return static_cast<std::uint8_t>(word & 0xff); };
  const auto high = [](std::uint16_t word) { return static_cast<std::uint8_t>(word >> 8); };
  return {{18, 1, 0x00, 0x02, 0, 0, 0, 64, 0xfb, 0x1f, low(product_id), high(product_id),
           low(firmware), high(firmware), 1, 2, 3, 1},
          {9, 2, 18, 0, 1, 1, 0, 0x80, 50, 9, 4, 0, 0, 0, 0xff, 0, 0, 0},
          {"Pololu Corporation", "Pololu Tic 36v4", serial, "-"},
          12};
}

void EmulatedTic::boot() {
  boot_s_ = last_command_s_ = now_s_;
  count_from(0);
  speed_ = 0.0;
  input_ = Input::kHalt;
  homing_ = Homing::kNone;
  errors_ = errors_occurred_ = 0;
  uncertain_ = true;
  deenergized_on_purpose_ = true;
  state_ = kReset;
  safe_start_exit_until_s_ = now_s_;
  load_settings();
  judge_state();
}

void EmulatedTic::load_settings() {
  settings_ = eeprom_;
  starting_speed_ = 0;
  max_speed_ = setting_of(kStoredMaxSpeed, 4);
  max_acceleration_ = setting_of(kStoredMaxAcceleration, 4);
  max_deceleration_ = setting_of(kStoredMaxDeceleration, 4);
  if (max_deceleration_ == 0) max_deceleration_ = max_acceleration_;
}

std::uint32_t EmulatedTic::setting_of(std::uint8_t offset, int bytes) const {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i)
    value |= static_cast<std::uint32_t>(settings_[offset + static_cast<std::size_t>(i)]) << (8 * i);
  return value;
}

void EmulatedTic::set(Error error, bool on) {
  const unsigned bit = 1U << error;
  if (on && !has(error)) errors_occurred_ |= bit;
  errors_ = on ? errors_ | bit : errors_ & ~bit;
}

void EmulatedTic::count_from(std::int32_t position) {
  offset_pulses_ += position_ - position;
  position_ = position;
}

void EmulatedTic::halt_abruptly(bool uncertain) {
  speed_ = 0.0;
  decelerates_to_hold_ = false;
  homing_ = Homing::kNone;
  uncertain_ = uncertain_ || uncertain;
}

void EmulatedTic::enter(State state) {
  if (state == state_) return;
  const bool was_normal = state_ == kNormal;
  state_ = state;
  if (state == kReset || state == kDeenergized) halt_abruptly(true);
  if (state == kStartingUp) started_s_ = now_s_;
  if (state == kNormal) decelerates_to_hold_ = false;
  if (state != kSoftError || !was_normal) return;
  homing_ = Homing::kNone;
  const std::uint32_t response = setting_of(kSoftErrorResponse, 1);
  if (response == kDeenergize || response == kHaltAndHold)
    halt_abruptly(true);
  else
    decelerates_to_hold_ = true;
}

void EmulatedTic::judge_state() {
  const std::uint32_t timeout_ms = setting_of(kCommandTimeoutMs, 2);
  set(kIntentionallyDeenergized, deenergized_on_purpose_);
  set(kLowSupply, supply_v_ < kLowSupply_v);
  set(kKillSwitch, kill_switch_);
  if (timeout_ms > 0 && now_s_ - last_command_s_ > timeout_ms * 1e-3) set(kCommandTimeout, true);
  if (state_ != kNormal && now_s_ >= safe_start_exit_until_s_ && settings_[kDisableSafeStart] == 0)
    set(kSafeStart, true);
  if (has(kDriverError) || has(kLowSupply)) return enter(kReset);
  if (has(kIntentionallyDeenergized)) return enter(kDeenergized);
  if (errors_ != 0) return enter(kSoftError);
  if (state_ == kReset || state_ == kDeenergized) return enter(kStartingUp);
  if (state_ == kStartingUp && now_s_ - started_s_ < kStartUp_s) return;
  enter(kNormal);
}

bool EmulatedTic::switch_closed(bool forward) const {
  const double shaft = position_ + offset_pulses_;
  if (forward) return settings_[kForwardPins] != 0 && forward_at_ && shaft >= *forward_at_;
  return settings_[kReversePins] != 0 && reverse_at_ && shaft <= *reverse_at_;
}

bool EmulatedTic::blocked(double speed) const {
  return (speed > 0.0 && switch_closed(true)) || (speed < 0.0 && switch_closed(false));
}

double EmulatedTic::wanted_speed() const {
  const double fastest = max_speed_ / kSpeedUnits;
  if (homing_ == Homing::kTowards || homing_ == Homing::kAway) {
    const bool forward = homing_forward_ == (homing_ == Homing::kTowards);
    const std::uint8_t setting =
        homing_ == Homing::kTowards ? kHomingSpeedTowards : kHomingSpeedAway;
    return (forward ? 1.0 : -1.0) * setting_of(setting, 4) / kSpeedUnits;
  }
  if (state_ != kNormal || homing_ == Homing::kPause) return 0.0;
  if (input_ == Input::kVelocity)
    return std::clamp(target_velocity_ / kSpeedUnits, -fastest, fastest);
  if (input_ == Input::kHalt) return 0.0;
  const double ahead = target_position_ - position_;
  const double braking = std::sqrt(2.0 * max_deceleration_ / kAccelerationUnits * std::abs(ahead));
  return std::copysign(std::min(fastest, braking), ahead);
}

void EmulatedTic::move(double dt_s) {
  const double wanted = wanted_speed();
  const bool faster = std::abs(wanted) > std::abs(speed_) && wanted * speed_ >= 0.0;
  const double change =
      (faster ? max_acceleration_ : max_deceleration_) / kAccelerationUnits * dt_s;
  speed_ += std::clamp(wanted - speed_, -change, change);
  if (state_ == kNormal && input_ == Input::kPosition && homing_ == Homing::kNone) {
    const double ahead = target_position_ - position_;
    if (std::abs(ahead) <= std::max(0.5, std::abs(speed_) * dt_s) &&
        std::abs(speed_) * dt_s < 1.0) {
      position_ = target_position_;
      speed_ = 0.0;
      return;
    }
  }
  if (blocked(speed_)) return halt_at_switch();
  position_ += speed_ * dt_s;
}

void EmulatedTic::halt_at_switch() {
  speed_ = 0.0;
  if (homing_ == Homing::kNone) uncertain_ = true;
}

void EmulatedTic::run_homing() {
  if (homing_ == Homing::kTowards && switch_closed(homing_forward_)) {
    speed_ = 0.0;
    homing_ = Homing::kPause;
    homing_pause_until_s_ = now_s_ + kHomingPause_s;
  } else if (homing_ == Homing::kPause && now_s_ >= homing_pause_until_s_) {
    homing_ = Homing::kAway;
  } else if (homing_ == Homing::kAway && !switch_closed(homing_forward_)) {
    speed_ = 0.0;
    homing_ = Homing::kNone;
    input_ = Input::kHalt;
    count_from(0);
    uncertain_ = false;
  }
}

void EmulatedTic::step(double dt_s) {
  now_s_ += dt_s;
  judge_state();
  run_homing();
  const bool turns = state_ == kNormal || decelerates_to_hold_;
  if (!turns) return;
  move(dt_s);
  const auto shaft = static_cast<std::int32_t>(std::lround(position_ + offset_pulses_));
  if (shaft == reported_shaft_) return;
  reported_shaft_ = shaft;
  last_motion_s_ = now_s_;
  if (on_position_) on_position_(shaft);
}

void EmulatedTic::advance() {
  const double until_s = clock_.now_s();
  while (until_s - now_s_ > kStep_s) step(kStep_s);
}

bool EmulatedTic::quick(std::uint8_t request, std::uint16_t value) {
  switch (request) {
    case 0x10:  // reinitialize
    case 0xb0:  // reset
      load_settings();
      halt_abruptly(true);
      count_from(0);
      input_ = Input::kHalt;
      errors_occurred_ = 0;
      set(kCommandTimeout, false);
      last_command_s_ = now_s_;
      safe_start_exit_until_s_ = now_s_;
      state_ = kReset;
      return true;
    case 0x83:  // exit safe start
      set(kSafeStart, false);
      safe_start_exit_until_s_ = now_s_ + kSafeStartExit_s;
      return true;
    case 0x85:
      deenergized_on_purpose_ = false;
      return true;
    case 0x86:
      deenergized_on_purpose_ = true;
      return true;
    case 0x89:  // halt and hold
      input_ = Input::kHalt;
      halt_abruptly(true);
      return true;
    case 0x8a:
      set(kDriverError, false);
      return true;
    case 0x8c:
      return true;
    case 0x8f:  // enter safe start
      safe_start_exit_until_s_ = now_s_;
      set(kSafeStart, true);
      return true;
    case 0x97:  // go home
      if (state_ != kNormal) return true;
      uncertain_ = true;
      homing_ = Homing::kTowards;
      homing_forward_ = value == 1;
      return true;
    default:
      return false;
  }
}

bool EmulatedTic::word(std::uint8_t request, std::uint32_t value) {
  const auto signed_value = static_cast<std::int32_t>(value);
  const bool obeys = settings_[kControlMode] == 0;
  switch (request) {
    case 0xe0:
      ++targets_received_;
      if (!obeys) return true;
      homing_ = Homing::kNone;
      input_ = Input::kPosition;
      target_position_ = signed_value;
      return true;
    case 0xe3:
      if (!obeys) return true;
      homing_ = Homing::kNone;
      input_ = Input::kVelocity;
      target_velocity_ = std::clamp(signed_value, -static_cast<std::int32_t>(kMaxSpeedUnits),
                                    static_cast<std::int32_t>(kMaxSpeedUnits));
      return true;
    case 0xec:  // halt and set position
      if (!obeys) return true;
      input_ = Input::kHalt;
      halt_abruptly(false);
      count_from(signed_value);
      uncertain_ = false;
      return true;
    case 0xe5:
      starting_speed_ = std::min(value, kMaxSpeedUnits);
      return true;
    case 0xe6:
      max_speed_ = std::min(value, kMaxSpeedUnits);
      return true;
    case 0xe9:
      max_deceleration_ = value == 0 ? max_acceleration_ : std::clamp(value, 100U, 0x7fffffffU);
      return true;
    case 0xea:
      max_acceleration_ = std::clamp(value, 100U, 0x7fffffffU);
      return true;
    default:
      return false;
  }
}

UsbOutcome EmulatedTic::control(const UsbSetup& setup, std::uint8_t* data) {
  const std::lock_guard lock(mutex_);
  advance();
  const UsbOutcome stall{-EPIPE, 0};
  if (setup.request_type == kVendorOut && setup.request == 0x13) {
    eeprom_[setup.index & 0xff] = static_cast<std::uint8_t>(setup.value & 0xff);
    return {0, 0};
  }
  if (setup.request_type == kVendorOut) {
    const std::uint32_t value = setup.value | static_cast<std::uint32_t>(setup.index) << 16;
    if (!quick(setup.request, setup.value) && !word(setup.request, value)) return stall;
    static constexpr std::array<std::uint8_t, 8> kFeeding{0xe0, 0xe3, 0xec, 0x89,
                                                          0x85, 0x83, 0xb0, 0x8c};
    if (std::count(kFeeding.begin(), kFeeding.end(), setup.request) > 0) {
      last_command_s_ = now_s_;
      set(kCommandTimeout, false);
    }
    judge_state();
    return {0, 0};
  }
  constexpr std::uint16_t kMaxBlock = 128;
  if (setup.request_type != kVendorIn || setup.length > kMaxBlock) return stall;
  const bool asks_settings = setup.request == 0xa8;
  if (!asks_settings && setup.request != 0xa1 && setup.request != 0xa2) return stall;
  const auto bytes = asks_settings ? eeprom_ : variables();
  if (setup.index + setup.length > static_cast<int>(bytes.size())) return stall;
  std::copy_n(bytes.begin() + setup.index, setup.length, data);
  if (setup.request == 0xa2) errors_occurred_ = 0;
  return {0, setup.length};
}

std::array<std::uint8_t, 256> EmulatedTic::variables() const {
  std::array<std::uint8_t, 256> bytes{};
  const bool energized = state_ != kReset && state_ != kDeenergized;
  const bool to_position =
      state_ == kNormal && input_ == Input::kPosition && homing_ == Homing::kNone;
  const bool to_velocity = homing_ != Homing::kNone || decelerates_to_hold_ ||
                           (state_ == kNormal && input_ == Input::kVelocity);
  const unsigned flags = (energized ? 1U : 0U) | (uncertain_ ? 2U : 0U) |
                         (switch_closed(true) ? 4U : 0U) | (switch_closed(false) ? 8U : 0U) |
                         (homing_ != Homing::kNone ? 16U : 0U);
  put(bytes, 0x00, state_, 1);
  put(bytes, 0x01, flags, 1);
  put(bytes, 0x02, errors_, 2);
  put(bytes, 0x04, errors_occurred_, 4);
  put(bytes, 0x09, to_position ? 1 : to_velocity ? 2 : 0, 1);
  put(bytes, 0x0a, to_position ? static_cast<std::uint32_t>(target_position_) : 0, 4);
  put(bytes, 0x0e, to_velocity ? static_cast<std::uint32_t>(target_velocity_) : 0, 4);
  put(bytes, 0x12, starting_speed_, 4);
  put(bytes, 0x16, max_speed_, 4);
  put(bytes, 0x1a, max_deceleration_, 4);
  put(bytes, 0x1e, max_acceleration_, 4);
  put(bytes, 0x22, static_cast<std::uint32_t>(std::lround(position_)), 4);
  put(bytes, 0x26, static_cast<std::uint32_t>(std::lround(speed_ * kSpeedUnits)), 4);
  put(bytes, 0x33, static_cast<std::uint32_t>(std::lround(supply_v_ * 1e3)), 2);
  put(bytes, 0x35, static_cast<std::uint32_t>(std::lround((now_s_ - boot_s_) * 1e3)), 4);
  return bytes;
}

std::int32_t EmulatedTic::shaft_pulses() {
  const std::lock_guard lock(mutex_);
  advance();
  return static_cast<std::int32_t>(std::lround(position_ + offset_pulses_));
}

double EmulatedTic::last_motion_s() {
  const std::lock_guard lock(mutex_);
  advance();
  return last_motion_s_;
}

int EmulatedTic::targets_received() {
  const std::lock_guard lock(mutex_);
  return targets_received_;
}

void EmulatedTic::place_switches(std::optional<std::int32_t> reverse_at,
                                 std::optional<std::int32_t> forward_at) {
  const std::lock_guard lock(mutex_);
  advance();
  reverse_at_ = reverse_at;
  forward_at_ = forward_at;
  eeprom_[kReversePins] = settings_[kReversePins] = reverse_at ? 1 : 0;
  eeprom_[kForwardPins] = settings_[kForwardPins] = forward_at ? 2 : 0;
}

void EmulatedTic::set_homing_speeds(double towards_pulses_s, double away_pulses_s) {
  const std::lock_guard lock(mutex_);
  advance();
  const auto store = [this](std::size_t offset, double speed_pulses_s) {
    const auto units = static_cast<std::uint32_t>(std::lround(speed_pulses_s * kSpeedUnits));
    put(eeprom_, offset, units, 4);
    put(settings_, offset, units, 4);
  };
  store(kHomingSpeedTowards, towards_pulses_s);
  store(kHomingSpeedAway, away_pulses_s);
}

void EmulatedTic::set_supply(double volts) {
  const std::lock_guard lock(mutex_);
  advance();
  supply_v_ = volts;
  judge_state();
}

void EmulatedTic::press_kill_switch(bool pressed) {
  const std::lock_guard lock(mutex_);
  advance();
  kill_switch_ = pressed;
  judge_state();
}

void EmulatedTic::power_cycle() {
  const std::lock_guard lock(mutex_);
  advance();
  boot();
}

void EmulatedTic::store_setting(std::uint8_t offset, std::uint8_t value) {
  const std::lock_guard lock(mutex_);
  advance();
  eeprom_[offset] = settings_[offset] = value;
}

std::uint8_t EmulatedTic::setting(std::uint8_t offset) {
  const std::lock_guard lock(mutex_);
  return eeprom_[offset];
}

}  // namespace planar::test
