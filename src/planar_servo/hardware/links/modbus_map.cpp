#include "planar_servo/hardware/links/modbus_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/base/io/yaml_reader.h"

namespace planar {
namespace {

using What = RegisterValue::What;

constexpr Named<bool> kWordOrders[] = {{true, "high_first"}, {false, "low_first"}};
constexpr Named<ModbusSpeed> kSpeeds[] = {{ModbusSpeed::kCounts, "counts_per_s"},
                                          {ModbusSpeed::kRpm, "rpm"}};
constexpr Named<ModbusAcceleration> kAccelerations[] = {
    {ModbusAcceleration::kCounts, "counts_per_s2"},
    {ModbusAcceleration::kRpmPerS, "rpm_per_s"},
    {ModbusAcceleration::kMsPer1000Rpm, "ms_per_1000_rpm"}};
constexpr Named<What> kValues[] = {
    {What::kPosition, "position"}, {What::kSpeed, "speed"}, {What::kAcceleration, "acceleration"}};
constexpr long kHighestWord = 0xffff;
constexpr double kRpmPerTurnPerS = 60.0;
constexpr double kRounding = 1.0 + 1e-9;  ///< of units that are no powers of two

/// Returns a number as C writes it: 18, 0x12. Empty for other texts and beyond 16 bits.
std::optional<long> word_of(const std::string& text) {
  std::size_t used = 0;
  try {
    const long value = std::stol(text, &used, 0);
    if (used == text.size() && value >= 0 && value <= kHighestWord) return value;
  } catch (const std::exception&) {
    // no number
  }
  return std::nullopt;
}

std::optional<RegisterValue> value_of(std::string text) {
  RegisterValue value;
  constexpr char kTwoWords[] = "/2";
  const bool is_wide = text.size() > 2 && text.substr(text.size() - 2) == kTwoWords;
  if (is_wide) text.resize(text.size() - 2);
  if (const auto named = value_named(kValues, text)) {
    value.what = *named;
  } else if (const auto number = word_of(text)) {
    value.number = *number;
  } else {
    return std::nullopt;
  }
  value.words = is_wide || value.what == What::kPosition ? 2 : 1;
  return value;
}

std::optional<RegisterWrite> write_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  const auto address = word_of(text.substr(0, colon));
  if (colon == text.npos || !address) return std::nullopt;
  RegisterWrite write{static_cast<int>(*address), {}};
  std::istringstream words(text.substr(colon + 1));
  for (std::string word; words >> word;) {
    const auto value = value_of(word);
    if (!value) return std::nullopt;
    write.values.push_back(*value);
  }
  return write.values.empty() ? std::nullopt : std::make_optional(write);
}

/// Refuses registers that are written as manuals number them, and not as they are on the line.
void check_address(YamlReader& file, const char* key, const std::string& text, int address) {
  constexpr int kFirst = 40001, kLast = 49999;
  const bool is_decimal = text.rfind("0x", 0) != 0 && text.rfind("0X", 0) != 0;
  file.check(!is_decimal || address < kFirst || address > kLast,
             {fmt::format("register {} is numbered as in manuals, from {}", address, kFirst),
              fmt::format("write its address on the line, {} or {:#06x}; in hexadecimal {:#06x} if "
                          "that is meant",
                          address - kFirst, address - kFirst, address)},
             key);
}

std::optional<RegisterRead> read_of(const std::string& text) {
  std::istringstream words(text);
  std::string address, count{"1"}, more;
  words >> address >> count >> more;
  const auto at = word_of(address);
  if (!at || (count != "1" && count != "2") || !more.empty()) return std::nullopt;
  return RegisterRead{static_cast<int>(*at), count == "2" ? 2 : 1};
}

std::optional<StatusBit> bit_of(const std::string& text) {
  constexpr char kNot[] = "not ";
  constexpr long kHighestBit = 31;
  const bool is_inverted = text.rfind(kNot, 0) == 0;
  const auto bit = word_of(is_inverted ? text.substr(std::char_traits<char>::length(kNot)) : text);
  if (!bit || *bit > kHighestBit || text.find_first_of("xX") != text.npos) return std::nullopt;
  return StatusBit{static_cast<int>(*bit), is_inverted};
}

/// Reads a text that `parse` understands.
template <typename Value, typename Parse>
void read_text(YamlReader& file, const char* key, Value& value, const Parse& parse,
               const std::string& rule) {
  std::string text;
  file.text(key, text);
  if (text.empty()) return;
  const auto parsed = parse(text);
  file.check(parsed.has_value(), {fmt::format("'{}' is not understood", text), rule}, key);
  if (parsed) value = *parsed;
}

constexpr char kWriteRule[] =
    "write REGISTER: VALUE..., each a number up to 0xffff, in move also position, speed or "
    "acceleration, with /2 where it fills two registers";
constexpr char kReadRule[] = "write REGISTER WORDS, such as 0x1014 2";
constexpr char kBitRule[] =
    "write the number of a bit of the status, or not N, in quotes; the mask 0x0004 is bit 2";

/// Reads how much one number of a driver is: a unit, or a size and a unit, such as "0.01 rpm".
template <typename Unit, std::size_t kSize>
void read_rate(YamlReader& file, const char* key, ModbusRate<Unit>& rate,
               const Named<Unit> (&units)[kSize]) {
  read_text(
      file, key, rate,
      [&](const std::string& text) -> std::optional<ModbusRate<Unit>> {
        const std::size_t space = text.find(' ');
        const auto unit = value_named(units, text.substr(space == text.npos ? 0 : space + 1));
        const auto size = space == text.npos ? 1.0 : finite_number(text.substr(0, space));
        if (!unit || !size || *size <= 0.0) return std::nullopt;
        return ModbusRate<Unit>{*unit, *size};
      },
      fmt::format("write one of {}, with the size of the driver's unit before it where that is "
                  "not 1, such as 0.01 rpm",
                  fmt::join(names_of(units), ", ")));
}

void read_register(YamlReader& file, const char* key, RegisterRead& value) {
  read_text(
      file, key, value,
      [&](const std::string& text) {
        const auto read = read_of(text);
        if (read) check_address(file, key, text, read->address);
        return read;
      },
      kReadRule);
}

/// Refuses what only a move has; it would be written as 0.
void check_numbers(YamlReader& file, const char* key, const RegisterWrite& write) {
  for (const RegisterValue& value : write.values)
    if (value.what != What::kNumber)
      file.check(
          false,
          {fmt::format("{} writes {}, which only `move` has", key, name_in(kValues, value.what)),
           "write a number"},
          key);
}

void read_writes(YamlReader& file, const char* key, std::vector<RegisterWrite>& writes,
                 bool is_needed) {
  if (!is_needed && !file.given(key)) return;
  std::vector<std::string> texts;
  file.texts(key, texts);
  for (const std::string& text : texts) {
    const auto write = write_of(text);
    file.check(write.has_value(), {fmt::format("'{}' is not understood", text), kWriteRule}, key);
    if (!write) continue;
    check_address(file, key, text, write->address);
    if (std::string_view(key) != "move") check_numbers(file, key, *write);
    writes.push_back(*write);
  }
}

/// Returns whether a write fills a register of `start` with what may start the driver.
bool may_start(const RegisterWrite& write, const RegisterWrite& start) {
  const RegisterValue& starter = start.values[0];
  int begin = write.address;
  for (const RegisterValue& value : write.values) {
    const int end = begin + value.words;
    const bool meets = begin < start.address + starter.words && start.address < end;
    if (meets && (value.what != What::kNumber || value.number == starter.number)) return true;
    begin = end;
  }
  return false;
}

/// Checks what one key cannot tell.
void check_whole(YamlReader& file, const ModbusMap& map) {
  for (const What what : {What::kPosition, What::kSpeed})
    file.check(!map.values_of(what).empty() || map.move.empty(),
               {fmt::format("move writes no {}", name_in(kValues, what)),
                "name it among its values", "", Cause::kMissing},
               "move");
  file.check(map.position.words == 2 || map.position.words == 0,
             {"position is one register", "a position needs two: REGISTER 2"}, "position");
  for (const RegisterWrite& write : map.move)
    file.check(!map.start || !may_start(write, *map.start),
               {"start is written by move, too, so that each joint would begin before the others",
                "leave it out of move, or leave start out", "", Cause::kContradiction},
               "start");
  const int bits = 16 * map.status.words;
  const auto check_bit = [&](const std::optional<StatusBit>& bit, const char* key) {
    if (bit)
      file.check(bit->bit < bits,
                 {fmt::format("{} is bit {} of {}", key, bit->bit, bits), kBitRule}, key);
  };
  check_bit(map.moving, "moving");
  check_bit(map.on, "on");
  check_bit(map.fault, "fault");
  check_bit(map.homed, "homed");
}

}  // namespace

std::vector<RegisterValue> ModbusMap::values_of(What what) const {
  std::vector<RegisterValue> found;
  for (const RegisterWrite& write : move)
    for (const RegisterValue& value : write.values)
      if (value.what == what) found.push_back(value);
  return found;
}

double ModbusMap::speed_in_units(double counts_s, double counts_per_turn) const {
  const bool is_rpm = speed.unit == ModbusSpeed::kRpm;
  return kRounding * (is_rpm ? kRpmPerTurnPerS * counts_s / counts_per_turn : counts_s) /
         speed.size;
}

long ModbusMap::speed_number(double counts_s, double counts_per_turn) const {
  return std::max(1L, static_cast<long>(speed_in_units(counts_s, counts_per_turn)));
}

long ModbusMap::acceleration_number(double counts_s2, double counts_per_turn) const {
  const double rpm_per_s = kRpmPerTurnPerS * counts_s2 / counts_per_turn;
  if (acceleration.unit == ModbusAcceleration::kMsPer1000Rpm)
    return std::clamp(static_cast<long>(std::ceil(1e6 / rpm_per_s / acceleration.size)), 1L,
                      static_cast<long>(longest_ramp));
  const double in_units = acceleration.unit == ModbusAcceleration::kRpmPerS ? rpm_per_s : counts_s2;
  return std::max(1L, static_cast<long>(std::floor(kRounding * in_units / acceleration.size)));
}

std::optional<Refusal> ModbusMap::misfit(const DriveLimits& limits, double counts_per_turn) const {
  const auto too_large = [&](What what, long number) -> std::optional<Refusal> {
    for (const RegisterValue& value : values_of(what))
      if (value.words == 1 && number > kHighestWord)
        return Refusal{
            fmt::format("the cell's largest {} is {} for the driver, more than one register holds",
                        name_in(kValues, what), number),
            fmt::format("write {}/2 in `move` if the driver takes it in two, else look at the "
                        "unit or lower the limit",
                        name_in(kValues, what))};
    return std::nullopt;
  };
  if (const double most = speed_in_units(limits.speed_pulses_s, counts_per_turn); most < 1.0)
    return Refusal{
        fmt::format("the cell's largest speed is {:.2g} times {:g} {}, less than one unit "
                    "of the driver",
                    most, speed.size, name_in(kSpeeds, speed.unit)),
        "compare the map's speed with the manual, or raise the limit"};
  const bool is_ramp = acceleration.unit == ModbusAcceleration::kMsPer1000Rpm;
  if (is_ramp &&
      acceleration_number(limits.acceleration_pulses_s2, counts_per_turn) >= longest_ramp)
    return Refusal{fmt::format("the cell's acceleration takes a ramp of {} or more in the driver's "
                               "numbers, its longest",
                               longest_ramp),
                   "compare the map's acceleration with the manual, or raise the limit"};
  if (auto why = too_large(What::kSpeed, speed_number(limits.speed_pulses_s, counts_per_turn)))
    return why;
  return too_large(What::kAcceleration,
                   acceleration_number(limits.acceleration_pulses_s2, counts_per_turn));
}

ModbusMap read_modbus_map(const std::filesystem::path& path) {
  YamlReader file(path, "modbus");
  ModbusMap map;
  file.text("name", map.name);
  file.text("source", map.source);
  file.choice("word_order", map.high_word_first, kWordOrders);
  read_register(file, "position", map.position);
  read_register(file, "status", map.status);
  if (file.given("alarm")) read_register(file, "alarm", map.alarm.emplace());
  read_text(file, "moving", map.moving, bit_of, kBitRule);
  if (file.given("on")) read_text(file, "on", map.on, bit_of, kBitRule);
  if (file.given("fault")) read_text(file, "fault", map.fault, bit_of, kBitRule);
  if (file.given("homed")) read_text(file, "homed", map.homed, bit_of, kBitRule);
  read_writes(file, "switch_on", map.switch_on, false);
  read_writes(file, "move", map.move, true);
  read_writes(file, "stop", map.stop, true);
  read_writes(file, "home_reverse", map.home_reverse, false);
  read_writes(file, "home_forward", map.home_forward, false);
  if (file.given("start")) read_text(file, "start", map.start, write_of, kWriteRule);
  if (map.start) check_numbers(file, "start", *map.start);
  read_rate(file, "speed", map.speed, kSpeeds);
  if (!map.values_of(What::kAcceleration).empty() || file.given("acceleration"))
    read_rate(file, "acceleration", map.acceleration, kAccelerations);
  if (file.given("longest_ramp")) {
    file.whole_number("longest_ramp", map.longest_ramp, 1, static_cast<int>(kHighestWord));
    file.check(map.acceleration.unit == ModbusAcceleration::kMsPer1000Rpm,
               {"longest_ramp limits nothing, for acceleration is not in ms_per_1000_rpm",
                "leave it out, or correct acceleration", "", Cause::kContradiction},
               "longest_ramp");
  }
  check_whole(file, map);
  file.throw_if_faulty();
  return map;
}

}  // namespace planar
