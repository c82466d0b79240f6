#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

// These functions split and write the lines of a CSV table, field by field [RFC 4180].

/// Returns the text without the blanks around it.
std::string_view trimmed(std::string_view text);

bool is_comment(std::string_view line);

/// Returns a comment without what a spreadsheet that saved its table put around it: quotes, and the
/// separators of empty fields. Empty for a line that is no comment.
std::string_view remark_of(std::string_view line);

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

/// Returns the text as a finite number with a decimal point, whatever the locale. Empty when the
/// whole text is not such a number.
std::optional<double> finite_number(std::string_view text);

// These functions judge the names of columns.

/// Returns the one of these columns that a name which is none of them likely stands for: a name
/// that is misspelt, has no unit or another one. Empty for a name that has nothing to do with them.
std::string likely_column(std::string_view name, const std::vector<std::string>& columns);

/// Returns a column with the unit that its name states, such as "x_mm (in millimetres)".
std::string with_unit(const std::string& column);

}  // namespace planar
