#include "planar_servo/io/yaml_fields.h"

#include <utility>

namespace planar {

bool FieldReader::given(const std::string& key, bool /*wanted*/) {
  return map_now().has(key);
}

bool FieldReader::number(const std::string& key, double& field, double unit, const Range& range) {
  const std::optional<double> value = map_now().child(key).as_number(range);
  if (value) field = *value * unit;
  return value.has_value();
}

void FieldReader::text(const std::string& key, std::string& field) {
  field = map_now().text(key);
}

bool FieldReader::numbers(const std::string& key, std::vector<double>& field, std::size_t size,
                          double unit, const Range& range) {
  auto values = map_now().child(key).as_numbers(size, range);
  if (!values) return false;
  field = std::move(*values);
  for (double& value : field) value *= unit;
  return true;
}

bool FieldReader::check(bool kept, const std::string& message, const std::string& key) {
  if (!kept) (key.empty() ? map_now() : map_now().child(key)).add_fault(message);
  return kept;
}

bool FieldReader::choice(const std::string& key, std::string& field,
                         const std::vector<std::string>& allowed) {
  auto value = map_now().child(key).as_choice(allowed);
  if (!value) return false;
  field = std::move(*value);
  return true;
}

bool FieldReader::names(const std::string& key, std::vector<std::string>& field, std::size_t size,
                        const std::vector<std::string>& allowed) {
  const auto items = map_now().child(key).as_list(size);
  if (!items) return false;
  field.clear();
  for (const YamlNode& item : *items) {
    std::optional<std::string> text = allowed.empty() ? item.as_text() : item.as_choice(allowed);
    if (text) field.push_back(std::move(*text));
  }
  return field.size() == items->size();
}

bool FieldReader::numbers_in_file(const std::string& key, std::vector<double>& field,
                                  const std::vector<Range>& ranges) {
  auto values = map_now().child(key).as_row(ranges);
  if (!values) return false;
  field = std::move(*values);
  return true;
}

bool FieldReader::rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                               std::size_t size, const std::vector<Range>& ranges) {
  const auto items = map_now().child(key).as_list(size);
  if (!items) return false;
  field.clear();
  for (const YamlNode& item : *items)
    if (auto values = item.as_row(ranges)) field.push_back(std::move(*values));
  return field.size() == items->size();
}

void FieldReader::begin_map(const std::string& key) {
  maps_.push_back(map_now().child(key));
}

std::size_t FieldReader::begin_list(const std::string& key, std::size_t size, bool fixed) {
  lists_.push_back(map_now().list(key, fixed ? size : 0));
  return lists_.back().size();
}

void FieldReader::begin_item(std::size_t i) {
  maps_.push_back(lists_.back()[i]);
}

bool FieldWriter::given(const std::string& /*key*/, bool wanted) {
  return wanted;
}

bool FieldWriter::number(const std::string& key, double& field, double unit,
                         const Range& /*range*/) {
  yaml_.add(key, field / unit);
  return true;
}

void FieldWriter::text(const std::string& key, std::string& field) {
  yaml_.add(key, field);
}

bool FieldWriter::numbers(const std::string& key, std::vector<double>& field, std::size_t /*size*/,
                          double unit, const Range& /*range*/) {
  std::vector<double> in_file = field;
  for (double& value : in_file) value /= unit;
  yaml_.add(key, in_file);
  return true;
}

bool FieldWriter::check(bool kept, const std::string& /*message*/, const std::string& /*key*/) {
  return kept;
}

bool FieldWriter::choice(const std::string& key, std::string& field,
                         const std::vector<std::string>& /*allowed*/) {
  yaml_.add(key, field);
  return true;
}

bool FieldWriter::names(const std::string& key, std::vector<std::string>& field,
                        std::size_t /*size*/, const std::vector<std::string>& /*allowed*/) {
  yaml_.add(key, field);
  return true;
}

bool FieldWriter::numbers_in_file(const std::string& key, std::vector<double>& field,
                                  const std::vector<Range>& /*ranges*/) {
  yaml_.add(key, field);
  return true;
}

bool FieldWriter::rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                               std::size_t /*size*/, const std::vector<Range>& /*ranges*/) {
  yaml_.add(key, field);
  return true;
}

std::size_t FieldWriter::begin_list(const std::string& key, std::size_t size, bool /*fixed*/) {
  yaml_.begin_list(key);
  return size;
}

void FieldWriter::begin_item(std::size_t /*i*/) {
  yaml_.begin_item();
}

}  // namespace planar
