#include "planar_servo/io/columns.h"

#include <fmt/format.h>

#include "planar_servo/core/text.h"

namespace planar {

void Columns::refuse(std::string_view column, const std::string& word,
                     const std::vector<std::string>& allowed) {
  check(false, {fmt::format("{} is '{}'", column, word),
                fmt::format("allowed are {}", fmt::join(allowed, ", "))});
}

void Columns::point(std::string_view x, std::string_view y, Eigen::Vector2d& field, double unit,
                    Digits digits) {
  number(x, field.x(), unit, digits);
  number(y, field.y(), unit, digits);
}

void Columns::optional_point(std::string_view x, std::string_view y,
                             std::optional<Eigen::Vector2d>& field, double unit, Digits digits,
                             Column need) {
  std::optional<double> field_x, field_y;
  if (field) {
    field_x = field->x();
    field_y = field->y();
  }
  optional_number(x, field_x, unit, digits, need);
  optional_number(y, field_y, unit, digits, need);
  if (!reading()) return;
  field.reset();
  if (field_x && field_y) field = Eigen::Vector2d(*field_x, *field_y);
  check(field_x.has_value() == field_y.has_value(),
        {fmt::format("{} is ''", field_x ? y : x), "a finite number is needed"});
}

void ColumnNames::add(std::string_view column, Column need) {
  all_.emplace_back(column);
  (need == Column::kRequired ? required_ : optional_).emplace_back(column);
}

void ColumnNames::text(std::string_view column, std::string& /*field*/, Column need) {
  add(column, need);
}

void ColumnNames::number(std::string_view column, double& /*field*/, double /*unit*/,
                         Digits /*digits*/) {
  add(column, Column::kRequired);
}

void ColumnNames::whole_number(std::string_view column, int& /*field*/) {
  add(column, Column::kRequired);
}

void ColumnNames::optional_number(std::string_view column, std::optional<double>& /*field*/,
                                  double /*unit*/, Digits /*digits*/, Column need) {
  add(column, need);
}

void ColumnReader::text(std::string_view column, std::string& field, Column /*need*/) {
  field = table_.text(column);
}

void ColumnReader::number(std::string_view column, double& field, double unit, Digits /*digits*/) {
  field = table_.number(column) * unit;
}

void ColumnReader::whole_number(std::string_view column, int& field) {
  field = table_.whole_number(column);
}

void ColumnReader::optional_number(std::string_view column, std::optional<double>& field,
                                   double unit, Digits /*digits*/, Column /*need*/) {
  field = table_.optional_number(column);
  if (field) *field *= unit;
}

void ColumnReader::check(bool kept, const Refusal& refusal) {
  if (!kept) table_.add_fault(refusal);
}

void LineWriter::add(std::string_view field) {
  if (!is_first_) line_ += ',';
  line_ += field;
  is_first_ = false;
}

void LineWriter::text(std::string_view /*column*/, std::string& field, Column /*need*/) {
  add(csv_field(field));
}

void LineWriter::number(std::string_view /*column*/, double& field, double unit, Digits digits) {
  const double value = field / unit;
  add(digits.is_significant ? fmt::format("{:.{}g}", value, digits.count)
                            : fixed(value, digits.count));
}

void LineWriter::whole_number(std::string_view /*column*/, int& field) {
  add(std::to_string(field));
}

void LineWriter::optional_number(std::string_view column, std::optional<double>& field, double unit,
                                 Digits digits, Column /*need*/) {
  if (field)
    number(column, *field, unit, digits);
  else
    add("");
}

}  // namespace planar
