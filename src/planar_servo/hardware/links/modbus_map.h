#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"

namespace planar {

/// A value that is written into one register, or two.
struct RegisterValue {
  enum class What { kNumber, kPosition, kSpeed, kAcceleration };
  What what{What::kNumber};
  long number{0};
  int words{1};
};

/// Values that are written at once, from this register on.
struct RegisterWrite {
  int address{0};
  std::vector<RegisterValue> values{};
};

/// A value that is read, from one register or two.
struct RegisterRead {
  int address{0}, words{1};
};

/// A bit of the status, which may stand for the contrary.
struct StatusBit {
  int bit{0};
  bool is_inverted{false};

  bool in(long status) const { return ((status >> bit & 1) != 0) != is_inverted; }
};

/// In what a driver takes a speed or an acceleration: how much of a unit one of its numbers is.
template <typename Unit>
struct ModbusRate {
  Unit unit{};
  double size{1.0};
};
enum class ModbusSpeed { kCounts, kRpm };
enum class ModbusAcceleration { kCounts, kRpmPerS, kMsPer1000Rpm };

/// The registers of one make of stepper driver: calib/modbus/*.yaml, as doc/modbus.md describes it.
struct ModbusMap {
  std::string name, source;
  bool high_word_first{true};
  RegisterRead position, status;
  std::optional<RegisterRead> alarm;
  StatusBit moving;
  std::optional<StatusBit> on, fault;
  std::optional<StatusBit> homed;  ///< a search has found the home switch
  std::vector<RegisterWrite> switch_on, move, stop, home_reverse, home_forward;
  std::optional<RegisterWrite> start;  ///< of all drivers at once, after `move`
  ModbusRate<ModbusSpeed> speed;
  ModbusRate<ModbusAcceleration> acceleration;
  int longest_ramp{0xffff};  ///< the largest number that the driver takes as a ramp's time

  /// Returns the values of this kind among what `move` writes.
  std::vector<RegisterValue> values_of(RegisterValue::What what) const;
  /// Returns a speed, counts/s, in the driver's numbers.
  double speed_in_units(double counts_s, double counts_per_turn) const;
  /// Returns the driver's number for a speed in counts/s, rounded down but at least 1.
  long speed_number(double counts_s, double counts_per_turn) const;
  /// Returns the driver's number for an acceleration in counts/s2 that is not exceeded, at least 1;
  /// of a ramp's time at most `longest_ramp`.
  long acceleration_number(double counts_s2, double counts_per_turn) const;

  /// Returns why the numbers for these limits do not fit into the registers; empty where they do.
  std::optional<Refusal> misfit(const DriveLimits& limits, double counts_per_turn) const;
};

/// Reads it. Throws InputError naming every fault.
ModbusMap read_modbus_map(const std::filesystem::path& path);

}  // namespace planar
