#include "planar_servo/hardware/links/modbus_map.h"

#include <fmt/format.h>

#include <sstream>

#include "planar_servo/base/io/yaml_reader.h"

namespace planar {
namespace {

using What = RegisterValue::What;

constexpr Named<bool> kWordOrders[] = {{true, "high_first"}, {false, "low_first"}};
constexpr Named<ModbusSpeed> kSpeeds[] = {{ModbusSpeed::kCounts, "counts_per_s"},
                                          {ModbusSpeed::kRpm, "rpm"}};
constexpr Named<ModbusAcceleration> kAccelerations[] = {
    {ModbusAcceleration::kCounts, "counts_per_s2"},
    {ModbusAcceleration::kMsPer1000Rpm, "ms_per_1000_rpm"}};
constexpr Named<What> kValues[] = {
    {What::kPosition, "position"}, {What::kSpeed, "speed"}, {What::kAcceleration, "acceleration"}};
constexpr long kHighestWord = 0xffff;

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
  if (!bit || *bit > kHighestBit) return std::nullopt;
  return StatusBit{static_cast<int>(*bit), is_inverted};
}

/// Reads a text that `parse` understands.
template <typename Value, typename Parse>
void read_text(YamlReader& file, const char* key, Value& value, const Parse& parse,
               const char* rule) {
  std::string text;
  file.text(key, text);
  if (text.empty()) return;
  const auto parsed = parse(text);
  file.check(parsed.has_value(), {fmt::format("'{}' is not understood", text), rule}, key);
  if (parsed) value = *parsed;
}

constexpr char kWriteRule[] =
    "write REGISTER: VALUE..., each a number up to 0xffff, position, speed or acceleration, with "
    "/2 "
    "where it fills two registers";
constexpr char kReadRule[] = "write REGISTER WORDS, such as 0x1014 2";
constexpr char kBitRule[] = "write the number of a bit, or not N, in quotes";

void read_writes(YamlReader& file, const char* key, std::vector<RegisterWrite>& writes,
                 bool is_needed) {
  if (!is_needed && !file.given(key)) return;
  std::vector<std::string> texts;
  file.texts(key, texts);
  for (const std::string& text : texts) {
    const auto write = write_of(text);
    file.check(write.has_value(), {fmt::format("'{}' is not understood", text), kWriteRule}, key);
    if (write) writes.push_back(*write);
  }
}

bool has_position(const std::vector<RegisterWrite>& writes) {
  for (const RegisterWrite& write : writes)
    for (const RegisterValue& value : write.values)
      if (value.what == What::kPosition) return true;
  return false;
}

}  // namespace

ModbusMap read_modbus_map(const std::filesystem::path& path) {
  YamlReader file(path, "modbus");
  ModbusMap map;
  file.text("name", map.name);
  file.text("source", map.source);
  file.choice("word_order", map.high_word_first, kWordOrders);
  read_text(file, "position", map.position, read_of, kReadRule);
  read_text(file, "status", map.status, read_of, kReadRule);
  if (file.given("alarm")) read_text(file, "alarm", map.alarm, read_of, kReadRule);
  read_text(file, "moving", map.moving, bit_of, kBitRule);
  if (file.given("on")) read_text(file, "on", map.on, bit_of, kBitRule);
  if (file.given("fault")) read_text(file, "fault", map.fault, bit_of, kBitRule);
  read_writes(file, "switch_on", map.switch_on, false);
  read_writes(file, "move", map.move, true);
  read_writes(file, "stop", map.stop, true);
  read_writes(file, "home_reverse", map.home_reverse, false);
  read_writes(file, "home_forward", map.home_forward, false);
  if (file.given("start")) read_text(file, "start", map.start, write_of, kWriteRule);
  file.choice("speed", map.speed, kSpeeds);
  file.choice("acceleration", map.acceleration, kAccelerations);
  file.check(has_position(map.move), {"writes no position", "name it among its values"}, "move");
  file.throw_if_faulty();
  return map;
}

}  // namespace planar
