#include "planar_servo/base/io/columns.h"

#include <fmt/format.h>

#include <utility>

namespace planar {

std::string Digits::text(double value) const {
  return is_significant ? fmt::format("{:.{}g}", value, count) : fixed(value, count);
}

void Columns::refuse(std::string_view column, const std::string& word,
                     const std::vector<std::string>& allowed) {
  check(false,
        {fmt::format("{} is '{}'", column, word),
         fmt::format("allowed are {}", fmt::join(allowed, ", "))},
        column);
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
  const std::string_view empty = field_x ? y : x;
  check(field_x.has_value() == field_y.has_value(),
        {fmt::format("{} is ''", empty), "a finite number is needed"}, empty);
}

void Columns::text(std::string_view column, std::string& field, Column need) {
  if (reading())
    field = table_->text(column);
  else
    add(column, need, FieldKind::kText, field);
}

void Columns::number(std::string_view column, double& field, double unit, Digits digits) {
  if (reading())
    field = table_->number(column) * unit;
  else
    add(column, Column::kRequired, FieldKind::kNumber, digits.text(field / unit));
}

void Columns::whole_number(std::string_view column, int& field) {
  if (reading())
    field = table_->whole_number(column);
  else
    add(column, Column::kRequired, FieldKind::kWholeNumber, std::to_string(field));
}

void Columns::optional_number(std::string_view column, std::optional<double>& field, double unit,
                              Digits digits, Column need) {
  if (reading()) {
    field = table_->optional_number(column);
    if (field) *field *= unit;
  } else {
    add(column, need, FieldKind::kNumber, field ? digits.text(*field / unit) : "");
  }
}

void Columns::check(bool kept, const Refusal& refusal, std::string_view column) {
  if (reading() && !kept) table_->add_fault(refusal, column);
}

void Columns::add(std::string_view column, Column need, FieldKind kind, std::string text) {
  written_.push_back({std::string(column), need, kind, std::move(text)});
}

std::vector<std::string> Columns::names() const {
  std::vector<std::string> names;
  for (const WrittenField& written : written_) names.push_back(written.column);
  return names;
}

std::vector<std::string> Columns::names(Column need) const {
  std::vector<std::string> names;
  for (const WrittenField& written : written_)
    if (written.need == need) names.push_back(written.column);
  return names;
}

std::string Columns::line() const {
  std::string line;
  for (const WrittenField& written : written_) line += csv_field(written.text) + ',';
  line.back() = '\n';
  return line;
}

}  // namespace planar
