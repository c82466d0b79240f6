#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/csv_table.h"

namespace planar {

/// Says how a number is written: with so many decimals and never as a negative zero, or with so
/// many significant digits.
struct Digits {
  Digits(int decimals) : count(decimals) {}
  static Digits significant(int count) {
    Digits digits(count);
    digits.is_significant = true;
    return digits;
  }
  std::string text(double value) const;

  int count;
  bool is_significant{false};
};

/// Says whether a table may lack a column.
enum class Column { kRequired, kOptional };

/// What the fields of a column hold; a number's field may be empty.
enum class FieldKind { kText, kNumber, kWholeNumber };

/// A field of a row that was visited to be written.
struct WrittenField {
  std::string column;
  Column need;
  FieldKind kind;
  std::string text;
};

/// Visits the columns of a table's row, to read them or to write them. One function per table lists
/// them, always all of them and in the order of writing, and serves both directions:
///
///     void list_columns(Columns& columns, PairRow& row) {
///       columns.text("id", row.id);
///       columns.point("x_vision_mm", "y_vision_mm", row.p_vision, kMillimetre, 6);
///       columns.optional_number("phi_deg", row.phi, kDegree, 6, Column::kOptional);
///     }
///     const TableSchema<PairRow> kPairs{"pairs", list_columns};
///
/// A number in the file times `unit` is the field's value. When reading, a value that breaks its
/// rule is a fault of the table (CsvTable), and a missing column or an empty field leaves a text
/// empty and an optional number without a value. Writing changes no field.
class Columns {
 public:
  /// Writes the fields that it visits.
  Columns() = default;
  /// Reads the current row of `table`, which must outlive this object.
  explicit Columns(CsvTable& table) : table_(&table) {}

  bool reading() const { return table_ != nullptr; }

  void text(std::string_view column, std::string& field, Column need = Column::kRequired);
  void number(std::string_view column, double& field, double unit, Digits digits);
  void whole_number(std::string_view column, int& field);
  /// Visits a number whose field may be empty.
  void optional_number(std::string_view column, std::optional<double>& field, double unit,
                       Digits digits, Column need = Column::kOptional);
  /// Visits a value of an enumeration by its name in `table`.
  template <typename Value, std::size_t kSize>
  void choice(std::string_view column, Value& field, const Named<Value> (&table)[kSize]);
  /// Visits a value of an enumeration in a column that may be absent or empty.
  template <typename Value, std::size_t kSize>
  void choice(std::string_view column, std::optional<Value>& field,
              const Named<Value> (&table)[kSize]);
  void point(std::string_view x, std::string_view y, Eigen::Vector2d& field, double unit,
             Digits digits);
  /// Visits a point whose two fields may both be empty. One empty field alone is a fault.
  void optional_point(std::string_view x, std::string_view y, std::optional<Eigen::Vector2d>& field,
                      double unit, Digits digits, Column need = Column::kOptional);

  /// When reading, adds the refusal of a column's value, or of the whole row, to the table's faults
  /// unless its rule was `kept`.
  void check(bool kept, const Refusal& refusal, std::string_view column = {});

  /// Returns the names of the columns that were written.
  std::vector<std::string> names() const;
  /// Returns those of the columns that a table must have, or may lack.
  std::vector<std::string> names(Column need) const;
  /// Returns the row that was written, with its line end.
  std::string line() const;
  /// Returns the fields that were written, in their order.
  const std::vector<WrittenField>& written() const { return written_; }

 private:
  void add(std::string_view column, Column need, FieldKind kind, std::string text);
  void refuse(std::string_view column, const std::string& word,
              const std::vector<std::string>& allowed);

  CsvTable* table_{nullptr};
  std::vector<WrittenField> written_;
};

template <typename Value, std::size_t kSize>
void Columns::choice(std::string_view column, Value& field, const Named<Value> (&table)[kSize]) {
  std::string word = name_in(table, field);
  text(column, word);
  if (!reading()) return;
  const std::optional<Value> value = value_named(table, word);
  if (!value) return refuse(column, word, names_of(table));
  field = *value;
}

template <typename Value, std::size_t kSize>
void Columns::choice(std::string_view column, std::optional<Value>& field,
                     const Named<Value> (&table)[kSize]) {
  std::string word = field ? name_in(table, *field) : "";
  text(column, word, Column::kOptional);
  if (!reading()) return;
  field = value_named(table, word);
  if (!field && !word.empty()) refuse(column, word, names_of(table));
}

/// Says whether every row of a table has an id of its own.
enum class RowIds { kAny, kOwn };

/// Describes a table by its kind (`# format: planar-servo/<kind>/1`) and its columns.
template <typename Row>
struct TableSchema {
  const char* kind;
  std::function<void(Columns&, Row&)> list_columns;
  UnendedRow unended{UnendedRow::kWarned};
  RowIds ids{RowIds::kAny};

  /// Returns the columns with the fields of this row.
  Columns columns(Row row = {}) const {
    Columns columns;
    list_columns(columns, row);
    return columns;
  }
  /// Returns the first lines: the format, remarks and the names of the columns.
  std::string header(const std::vector<std::string>& remarks = {}) const {
    return csv_header(kind, columns().names(), remarks);
  }
  std::string line(const Row& row) const { return columns(row).line(); }
  /// Returns the whole table.
  std::string text(const std::vector<Row>& rows,
                   const std::vector<std::string>& remarks = {}) const {
    std::string text = header(remarks);
    for (const Row& row : rows) text += line(row);
    return text;
  }
};

/// Reads a table's file row by row:
///
///     TableFile<PairRow> table(path, kPairs);
///     for (PairRow row; table.next(row);) sum += row.p_vision;
///     table.throw_if_faulty_or_empty();
template <typename Row>
class TableFile : public CsvFile {
 public:
  /// Opens the file and throws as CsvFile() does. `schema` must outlive the table.
  TableFile(const CsvSource& source, const TableSchema<Row>& schema, const CsvDialect& dialect = {})
      : CsvFile(source, schema.kind, schema.columns().names(Column::kRequired), dialect,
                schema.unended, schema.columns().names(Column::kOptional)),
        schema_(schema) {}

  /// Reads the next row. Returns false at the end of the file.
  bool next(Row& row) {
    if (!next_row()) return false;
    schema_.list_columns(reader_, row);
    return true;
  }

  /// Reads the rows that are left, of which there may be none. Throws as throw_if_faulty() does.
  std::vector<Row> any_rows() {
    std::vector<Row> rows;
    std::set<std::string> taken;
    for (Row row; next(row); rows.push_back(row)) {
      if (schema_.ids == RowIds::kAny) continue;
      require_id_not_in(taken);
      taken.emplace(text("id"));
    }
    throw_if_faulty();
    return rows;
  }
  /// Reads the rows that are left. Throws as throw_if_faulty_or_empty() does.
  std::vector<Row> rows(const std::string& remedy = "at least one is needed") {
    std::vector<Row> rows = any_rows();
    throw_if_faulty_or_empty(remedy);
    return rows;
  }

 private:
  const TableSchema<Row>& schema_;
  Columns reader_{*this};
};

}  // namespace planar
