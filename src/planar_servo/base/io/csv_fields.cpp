#include "planar_servo/base/io/csv_fields.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>

#include "planar_servo/base/core/text.h"

namespace planar {
namespace {

/// Returns the index of the quote that closes the text quoted from `begin` on, or the size of the
/// text when none does.
std::size_t closing_quote(std::string_view text, std::size_t begin) {
  std::size_t at = text.find('"', begin);
  while (at != std::string_view::npos && text.substr(at + 1, 1) == "\"")
    at = text.find('"', at + 2);
  return std::min(at, text.size());
}

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

/// Returns the column of the same quantity whose unit this name misspells; empty where none is.
std::string with_misspelt_unit(std::string_view name, const std::vector<std::string>& columns) {
  std::vector<std::string> same;
  for (const std::string& column : columns)
    if (quantity_of(column) == name.substr(0, name.rfind('_'))) same.push_back(column);
  return nearest_word(name, same);
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr char kBlanks[] = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool is_comment(std::string_view line) {
  return trimmed(line).substr(0, 1) == "#";
}

std::string_view remark_of(std::string_view line) {
  line = trimmed(line);
  line = line.substr(0, line.find_last_not_of(",;\t ") + 1);
  if (line.substr(0, 2) == "\"#" && line.find('"', 1) == line.size() - 1)
    line = line.substr(1, line.size() - 2);
  return is_comment(line) ? line : std::string_view();
}

CsvField take_field(std::string_view& line, char separator) {
  CsvField field;
  std::size_t end = line.find(separator);
  field.text = trimmed(line.substr(0, end));
  if (field.text.substr(0, 1) == "\"") {
    field.is_quoted = true;
    const auto begin = static_cast<std::size_t>(field.text.data() - line.data()) + 1;
    const std::size_t quote = closing_quote(line, begin);
    field.text = line.substr(begin, quote - begin);
    end = line.find(separator, quote);
    field.is_closed =
        quote < line.size() &&
        trimmed(line.substr(quote + 1, end == std::string_view::npos ? end : end - quote - 1))
            .empty();
  }
  field.is_last = end == std::string_view::npos;
  line.remove_prefix(field.is_last ? line.size() : end + 1);
  return field;
}

bool ends_in_quotes(std::string_view text, bool in_quotes, char separator) {
  if (in_quotes) {
    const std::size_t quote = closing_quote(text, 0);
    if (quote == text.size()) return true;
    text.remove_prefix(std::min(text.find(separator, quote), text.size() - 1) + 1);
  }
  if (text.find('"') == std::string_view::npos) return false;
  CsvField last;
  while (!last.is_last) last = take_field(text, separator);
  return last.is_quoted && last.text.data() + last.text.size() == text.data() + text.size();
}

std::vector<std::string_view> split_fields(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  for (bool is_last = false; !is_last;) {
    const CsvField field = take_field(line, separator);
    fields.push_back(field.text);
    is_last = field.is_last;
  }
  return fields;
}

std::string csv_field(const std::string& text) {
  const bool plain = trimmed(text).size() == text.size() && !is_comment(text) &&
                     text.find_first_of(",\"\r\n") == std::string::npos;
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::optional<double> finite_number(std::string_view text) {
  if (text.substr(0, 1) == "+" && text.substr(1, 1) != "-") text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::string likely_column(std::string_view name, const std::vector<std::string>& columns) {
  std::vector<std::string> quantities;
  quantities.reserve(columns.size());
  for (const std::string& column : columns) quantities.push_back(quantity_of(column));
  const std::string nearest = nearest_word(quantity_of(as_ours(name)), quantities);
  if (nearest.empty()) return with_misspelt_unit(name, columns);
  const auto at = std::find(quantities.begin(), quantities.end(), nearest);
  return columns[static_cast<std::size_t>(at - quantities.begin())];
}

std::string with_unit(const std::string& column) {
  const auto unit = units_of_columns().find(unit_of(column));
  return unit == units_of_columns().end() ? column : column + " (in " + unit->second + ")";
}

}  // namespace planar
