#include "planar_servo/io/fields.h"

namespace planar {

void RowFields::number(double& field, double unit, const Range& range) {
  columns_.push_back({&field, nullptr, unit, range});
}

void RowFields::whole_number(int& field, int lower, int upper) {
  columns_.push_back({nullptr, &field, 1.0, Range::whole(lower, upper)});
}

std::vector<Range> RowFields::ranges() const {
  std::vector<Range> ranges;
  for (const Column& column : columns_) ranges.push_back(column.range);
  return ranges;
}

std::vector<double> RowFields::in_file() const {
  std::vector<double> values;
  for (const Column& column : columns_)
    values.push_back(column.whole ? *column.whole : *column.number / column.unit);
  return values;
}

void RowFields::take(const std::vector<double>& in_file) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const Column& column = columns_[i];
    if (column.whole)
      *column.whole = static_cast<int>(in_file[i]);
    else
      *column.number = in_file[i] * column.unit;
  }
}

void Fields::texts(const std::string& key, std::vector<std::string>& field) {
  names(key, field, 0, {});
}

}  // namespace planar
