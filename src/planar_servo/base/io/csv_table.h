#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {

/// Returns the first lines of a table: its format, remarks, each of which begins with '#', and its
/// columns.
std::string csv_header(const std::string& kind, const std::vector<std::string>& columns,
                       const std::vector<std::string>& remarks = {});

/// Says how another program's table differs from ours.
struct CsvDialect {
  char separator{','};
  bool decimal_comma{false};
  /// Maps our column names to those of the file.
  std::map<std::string, std::string> renamed_columns;
};

/// Reads a CSV table line by line and holds the current row only. Columns are found by name, in any
/// order. `#` comments, blank lines and rows, and columns behind the last that has a name are
/// skipped. Where the dialect's separator is a comma, a line `sep=;`, a header that has the columns
/// by it or one without commas says that it is a semicolon (then with decimal commas) or a tab.
/// Letters that are not UTF-8 are Latin-1's. Extra columns are ignored, unless they look like one
/// of ours that is not there. A field in quotes [RFC 4180] may hold the separator and line ends.
/// The first line may be `# format: planar-servo/<kind>/1`; another format there is refused. Faults
/// of rows are collected with FILE:LINE and thrown all at once.
class CsvTable {
 public:
  /// Begins without a header or a row. `source` names the file in messages, `optional` the columns
  /// that it may lack.
  CsvTable(std::filesystem::path source, const std::string& kind, std::vector<std::string> required,
           CsvDialect dialect = {}, std::vector<std::string> optional = {});
  CsvTable(const CsvTable&) = delete;  // the fields are views of the line
  CsvTable& operator=(const CsvTable&) = delete;
  virtual ~CsvTable() = default;

  /// Takes one more line. Returns true when it is a row, which is the current one then. A row whose
  /// number of fields differs from the header's is a fault. Throws InputError for another format
  /// and for a header that lacks a required column, names one twice or has a misnamed optional one;
  /// such a header is not taken.
  bool take_line(std::string_view line, int line_number);

  bool has_header() const { return !columns_.empty(); }
  bool has_column(const std::string& column) const;

  // These functions read the current row.

  /// Returns the field's text, which is valid until the next line. Empty when the column does not
  /// exist.
  std::string_view text(std::string_view column) const;
  /// Returns the field as a finite number. When it is not one, adds a fault and returns 0.
  double number(std::string_view column);
  /// Returns the field as a finite number. Empty for an empty field or a column that does not
  /// exist.
  std::optional<double> optional_number(std::string_view column);
  /// Returns the field as a whole number. When it is not one, adds a fault and returns 0.
  int whole_number(std::string_view column);
  /// Adds a fault when the field `id` is empty or one of `taken`.
  void require_id_not_in(const std::set<std::string>& taken);
  /// Adds a fault of the row, or of its field in this column, at FILE:LINE.
  void add_fault(const Refusal& refusal, std::string_view column = {});
  /// Adds a fault: the row has no line end, so that its last number may lack digits.
  void refuse_torn_row();

  /// Throws InputError with the faults so far, if there are any, and forgets them.
  void throw_if_faulty();
  /// Does what throw_if_faulty() does, and also throws InputError with this remedy when there was
  /// no row.
  void throw_if_faulty_or_empty(const std::string& remedy = "at least one is needed");

 protected:
  const std::filesystem::path& source() const { return source_; }
  char separator() const { return dialect_.separator; }
  std::string required_columns() const;
  int line_number() const { return line_number_; }
  /// Returns the place of the current row as messages name it, FILE:LINE.
  virtual std::string row() const;

 private:
  void read_header();
  /// Finds out by a header what separates the columns.
  void find_separator();
  void take_separator(char separator);
  void require_columns(const std::vector<std::string>& columns) const;
  /// Splits line_ into fields_. When a quoted field does not end, adds a fault and returns false.
  bool split_line();
  std::string_view without_doubled_quotes(std::string_view text);

  std::filesystem::path source_;
  std::string format_;
  std::vector<std::string> required_, optional_;
  CsvDialect dialect_;
  std::vector<std::string> columns_;
  std::string line_;
  int line_number_{0};
  std::vector<std::string_view> fields_;  ///< of line_ or unquoted_
  std::string unquoted_;                  ///< fields that had doubled quotes
  mutable std::size_t next_column_{0};    ///< most callers ask for the columns in their order
  std::size_t rows_{0};                   ///< with and without faults
  Faults faults_;
};

/// Says what a last row without a line end is: torn, as by a program that was killed while it
/// wrote, or whole, as some editors leave it.
enum class UnendedRow { kWarned, kRefused };

/// A table's file, or its text under the name of one.
struct CsvSource {
  CsvSource(std::filesystem::path file) : path(std::move(file)) {}
  CsvSource(std::filesystem::path name, std::string its_text)
      : path(std::move(name)), text(std::move(its_text)) {}

  std::filesystem::path path;
  std::optional<std::string> text{};
};

/// Reads a CSV file row by row:
///
///     CsvFile table(path, "pairs", {"id", "x_vision_mm"});
///     while (table.next_row()) sum += table.number("x_vision_mm");
///     table.throw_if_faulty_or_empty();
class CsvFile : public CsvTable {
 public:
  /// Reads the file up to its header. Throws InputError when the file cannot be read or has no
  /// header line, and when take_line() does.
  CsvFile(const CsvSource& source, const std::string& kind,
          const std::vector<std::string>& required, const CsvDialect& dialect = {},
          UnendedRow unended = UnendedRow::kWarned, const std::vector<std::string>& optional = {});

  /// Takes the next row. Returns false at the end of the file.
  bool next_row();

 private:
  bool next_line();

  std::istringstream in_;
  UnendedRow unended_;
  std::string buffer_;
  int lines_{0};
  int line_begin_{0};  ///< the number of the line where buffer_ begins
};

}  // namespace planar
