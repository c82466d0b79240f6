#include "planar_servo/io/likely_column.h"

#include <algorithm>
#include <cctype>
#include <map>

#include "planar_servo/core/text.h"

namespace planar {
namespace {

/// Maps the units that names of columns end with to words.
const std::map<std::string, std::string, std::less<>>& units_of_columns() {
  static const std::map<std::string, std::string, std::less<>> units{
      {"mm", "millimetres"},    {"deg", "degrees"},     {"px", "pixels"},      {"s", "seconds"},
      {"m", "metres"},          {"cm", "centimetres"},  {"um", "micrometres"}, {"rad", "radians"},
      {"mrad", "milliradians"}, {"ms", "milliseconds"}, {"us", "microseconds"}};
  return units;
}

/// Returns a name as ours are written: "X [mm]" and "x-mm" are x_mm.
std::string as_ours(std::string_view name) {
  std::string ours;
  for (const char c : name) {
    const bool is_part = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (is_part)
      ours += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!ours.empty() && ours.back() != '_')
      ours += '_';
  }
  while (!ours.empty() && ours.back() == '_') ours.pop_back();
  return ours;
}

/// Returns the unit that a name ends with; empty for one without.
std::string_view unit_of(std::string_view column) {
  const std::size_t end = column.rfind('_');
  if (end == std::string_view::npos) return {};
  const std::string_view unit = column.substr(end + 1);
  return units_of_columns().count(unit) == 0 ? std::string_view() : unit;
}

/// Returns what a name calls its values, without their unit.
std::string quantity_of(std::string_view column) {
  const std::string_view unit = unit_of(column);
  return std::string(column.substr(0, column.size() - (unit.empty() ? 0 : unit.size() + 1)));
}

}  // namespace

std::string likely_column(std::string_view name, const std::vector<std::string>& columns) {
  std::vector<std::string> quantities;
  quantities.reserve(columns.size());
  for (const std::string& column : columns) quantities.push_back(quantity_of(column));
  const std::string nearest = nearest_word(quantity_of(as_ours(name)), quantities);
  if (nearest.empty()) return {};
  const auto at = std::find(quantities.begin(), quantities.end(), nearest);
  return columns[static_cast<std::size_t>(at - quantities.begin())];
}

std::string with_unit(const std::string& column) {
  const auto unit = units_of_columns().find(unit_of(column));
  return unit == units_of_columns().end() ? column : column + " (in " + unit->second + ")";
}

}  // namespace planar
