#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planar {

// The lines of a CSV table, field by field [RFC 4180].

/// Without the blanks around it.
std::string_view trimmed(std::string_view text);

bool is_comment(std::string_view line);

/// A view of one field of a line, without the blanks or quotes around it; doubled quotes stay
/// doubled.
struct CsvField {
  std::string_view text;  ///< between its quotes, where it has some
  bool is_quoted{false};
  bool is_closed{true};  ///< whether a closing quote ends it
  bool is_last{false};   ///< of its line
};

/// Takes the first field and the separator behind it from a line.
CsvField take_field(std::string_view& line, char separator);

/// The fields of one line.
std::vector<std::string_view> split_fields(std::string_view line, char separator = ',');

/// Whether the text, which begins `in_quotes` or not, ends within quotes, so that the next line
/// goes on with it.
bool ends_in_quotes(std::string_view text, bool in_quotes, char separator);

/// A text as a field of a line, quoted where it must be to be read as it is.
std::string csv_field(const std::string& text);

}  // namespace planar
