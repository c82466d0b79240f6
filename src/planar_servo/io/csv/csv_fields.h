#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planar {

// These functions split and write the lines of a CSV table, field by field [RFC 4180].

/// Returns the text without the blanks around it.
std::string_view trimmed(std::string_view text);

bool is_comment(std::string_view line);

/// Views one field of a line, without the blanks or quotes around it. Doubled quotes stay doubled.
struct CsvField {
  std::string_view text;  ///< between its quotes, where it has some
  bool is_quoted{false};
  bool is_closed{true};  ///< whether a closing quote ends it
  bool is_last{false};   ///< of its line
};

/// Removes the first field and the separator behind it from a line, and returns the field.
CsvField take_field(std::string_view& line, char separator);

/// Returns the fields of one line.
std::vector<std::string_view> split_fields(std::string_view line, char separator = ',');

/// Returns whether the text ends within quotes, so that its last field continues on the next line.
/// `in_quotes` says whether the text also begins within quotes.
bool ends_in_quotes(std::string_view text, bool in_quotes, char separator);

/// Returns a text as a field of a line, in quotes where it could not be read back otherwise.
std::string csv_field(const std::string& text);

}  // namespace planar
