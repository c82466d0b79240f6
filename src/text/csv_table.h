#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"

namespace planar {

/// The whole text as a finite number with a decimal point, whatever the locale; empty otherwise.
std::optional<double> finite_number(const std::string& text);

/// The fields of one line, without the blanks around them.
std::vector<std::string> split_fields(const std::string& line, char separator = ',');

/// How other programs' tables differ from ours.
struct CsvDialect {
  char separator{','};
  bool decimal_comma{false};
  /// our column name -> the file's column name
  std::map<std::string, std::string> renamed_columns;
};

/// A CSV table whose columns are found by name in any order. `#` comments and blank lines are
/// skipped, extra columns ignored. Faults are collected with FILE:LINE, all at once:
///
///     CsvTable table = CsvTable::read(path, "pairs", {"id", "x_vision_mm"});
///     for (std::size_t row = 0; row < table.size(); ++row) x = table.number(row, "x_vision_mm");
///     table.throw_if_faulty();
class CsvTable {
 public:
  /// Reads the whole file. A first line `# format: planar-servo/<kind>/1` is optional, but another
  /// format there is refused. Throws InputError when the file cannot be read, has no header line or
  /// lacks a column of `required`.
  static CsvTable read(const std::filesystem::path& path, const std::string& kind,
                       const std::vector<std::string>& required, const CsvDialect& dialect = {});

  /// A table without lines yet. `source` stands for the file in messages.
  CsvTable(std::filesystem::path source, const std::string& kind, std::vector<std::string> required,
           CsvDialect dialect = {});

  /// Takes one line more. Throws InputError for a header that lacks a required column and for
  /// another format; everything else that is wrong is a fault of the row.
  void add_line(std::string line, int line_number);

  bool has_header() const { return !columns_.empty(); }
  std::size_t size() const { return rows_.size(); }
  bool has_column(const std::string& column) const { return columns_.count(column) != 0; }
  int line(std::size_t row) const { return rows_[row].line; }
  const std::filesystem::path& path() const { return path_; }

  /// The field's text; empty when the column does not exist.
  const std::string& text(std::size_t row, const std::string& column) const;

  /// The field as a finite number; a fault (and 0) when it is not one.
  double number(std::size_t row, const std::string& column);
  /// Empty for an empty field or a column that does not exist.
  std::optional<double> optional_number(std::size_t row, const std::string& column);
  /// The field as a whole number; a fault (and 0) when it is not one.
  int whole_number(std::size_t row, const std::string& column);

  /// Adds `FILE:LINE: message`.
  void add_fault(std::size_t row, const std::string& message);
  /// Adds a fault for every row whose id is empty or stands above it already.
  void require_distinct_ids();
  void throw_if_faulty() const { faults_.throw_if_any(); }
  /// Throws as well when there is no row, with `remedy` after the semicolon.
  void throw_if_faulty_or_empty(const std::string& remedy = "at least one is needed") const;

 private:
  struct Row {
    int line{0};
    std::vector<std::string> fields;
  };

  void read_header(const std::vector<std::string>& names, int line_number);

  std::filesystem::path path_;
  std::string format_;
  std::vector<std::string> required_;
  CsvDialect dialect_;
  std::map<std::string, std::size_t> columns_;
  std::vector<Row> rows_;
  Faults faults_;
};

/// Builds the text of a CSV file with its format line and header. Numbers are written with a
/// decimal point whatever the locale.
class CsvWriter {
 public:
  CsvWriter(const std::string& kind, const std::vector<std::string>& columns);

  CsvWriter& add(const std::string& text);
  CsvWriter& add(double value, int decimals);
  CsvWriter& add_significant(double value, int digits);
  CsvWriter& add_empty();
  /// Throws std::logic_error unless the row has one field per column.
  void end_row();

  const std::string& text() const { return text_; }

 private:
  std::size_t columns_;
  std::size_t fields_{0};
  std::string text_;
};

}  // namespace planar
