#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

enum class ModbusSpeed { kCounts, kRpm };
enum class ModbusAcceleration { kCounts, kMsPer1000Rpm };

/// The registers of one make of stepper driver: calib/modbus/*.yaml, as doc/modbus.md describes it.
struct ModbusMap {
  std::string name, source;
  bool high_word_first{true};
  RegisterRead position, status;
  std::optional<RegisterRead> alarm;
  StatusBit moving;
  std::optional<StatusBit> on, fault;
  std::vector<RegisterWrite> switch_on, move, stop, home_reverse, home_forward;
  std::optional<RegisterWrite> start;  ///< of all drivers at once, after `move`
  ModbusSpeed speed{ModbusSpeed::kCounts};
  ModbusAcceleration acceleration{ModbusAcceleration::kCounts};
};

/// Reads it. Throws InputError naming every fault.
ModbusMap read_modbus_map(const std::filesystem::path& path);

}  // namespace planar
