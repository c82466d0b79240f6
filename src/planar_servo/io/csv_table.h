#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/core/error.h"
#include "planar_servo/io/csv_fields.h"

namespace planar {

/// The whole text as a finite number with a decimal point, whatever the locale; empty otherwise.
std::optional<double> finite_number(std::string_view text);

/// The first two lines of a table: its format and its columns.
std::string csv_header(const std::string& kind, const std::vector<std::string>& columns);

/// How other programs' tables differ from ours.
struct CsvDialect {
  char separator{','};
  bool decimal_comma{false};
  /// our column name -> the file's column name
  std::map<std::string, std::string> renamed_columns;
};

/// A CSV table whose columns are found by name in any order, taken line by line: it holds the
/// current row only. `#` comments and blank lines are skipped, extra columns ignored. A field in
/// quotes [RFC 4180] may hold the separator and line ends. A first line
/// `# format: planar-servo/<kind>/1` is optional, but another format there is refused. Faults of
/// rows are collected with FILE:LINE, to be thrown all at once.
class CsvTable {
 public:
  /// `source` stands for the file in messages.
  CsvTable(std::filesystem::path source, const std::string& kind, std::vector<std::string> required,
           CsvDialect dialect = {});
  CsvTable(const CsvTable&) = delete;  // the fields are views of the line
  CsvTable& operator=(const CsvTable&) = delete;

  /// Takes one line more; true when it is a row, which then is the current one. A row with another
  /// number of fields than the header is a fault. Throws InputError for another format and for a
  /// header that lacks a required column or names one twice; such a header is not taken.
  bool take_line(std::string_view line, int line_number);

  bool has_header() const { return !columns_.empty(); }

  // Of the current row.

  /// The field's text; empty when the column does not exist. Valid until the next line.
  std::string_view text(std::string_view column) const;
  /// The field as a finite number; a fault (and 0) when it is not one.
  double number(std::string_view column);
  /// Empty for an empty field or a column that does not exist.
  std::optional<double> optional_number(std::string_view column);
  /// The field as a whole number; a fault (and 0) when it is not one.
  int whole_number(std::string_view column);
  /// A fault when the field `id` is empty or one of `taken`.
  void require_id_not_in(const std::set<std::string>& taken);
  /// Adds `FILE:LINE: message`.
  void add_fault(const std::string& message);

  /// Throws InputError with the faults so far, which are forgotten then.
  void throw_if_faulty();
  /// Throws as well when there was no row, with `remedy` after the semicolon.
  void throw_if_faulty_or_empty(const std::string& remedy = "at least one is needed");

 protected:
  const std::filesystem::path& source() const { return source_; }
  char separator() const { return dialect_.separator; }
  std::string required_columns() const;

 private:
  void read_header(int line_number);
  /// line_ into fields_; false, and a fault, when a quoted field does not end.
  bool split_line();
  std::string_view without_doubled_quotes(std::string_view text);

  std::filesystem::path source_;
  std::string format_;
  std::vector<std::string> required_;
  CsvDialect dialect_;
  std::vector<std::string> columns_;
  std::string line_;
  int line_number_{0};
  std::vector<std::string_view> fields_;  ///< of line_ or unquoted_
  std::string unquoted_;                  ///< fields that had doubled quotes
  mutable std::size_t next_column_{0};    ///< most callers ask for the columns in their order
  bool has_rows_{false};
  Faults faults_;
};

/// A CSV file, read row by row:
///
///     CsvFile table(path, "pairs", {"id", "x_vision_mm"});
///     while (table.next_row()) sum += table.number("x_vision_mm");
///     table.throw_if_faulty_or_empty();
class CsvFile : public CsvTable {
 public:
  /// Throws InputError when the file cannot be read or has no header line, and as `take_line`.
  CsvFile(const std::filesystem::path& path, const std::string& kind,
          const std::vector<std::string>& required, const CsvDialect& dialect = {});

  /// False at the end of the file.
  bool next_row();

 private:
  bool next_line();

  std::ifstream in_;
  std::string buffer_;
  int lines_{0};
  int line_begin_{0};  ///< the number of the line where buffer_ begins
};

}  // namespace planar
