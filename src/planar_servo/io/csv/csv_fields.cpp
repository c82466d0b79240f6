#include "planar_servo/io/csv/csv_fields.h"

#include <algorithm>

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

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr char kBlanks[] = " \t\r";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool is_comment(std::string_view line) {
  return trimmed(line).substr(0, 1) == "#";
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

}  // namespace planar
