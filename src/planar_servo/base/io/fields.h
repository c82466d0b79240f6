#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"

namespace planar {

/// Describes the rule for a number in a file, in the unit of the file. Every number must also be
/// finite.
class Range {
 public:
  static constexpr double kUnbounded = std::numeric_limits<double>::max();

  static Range any() { return {-kUnbounded, kUnbounded, false}; }
  static Range from_to(double lower, double upper) { return {lower, upper, false}; }
  static Range at_least(double lower) { return {lower, kUnbounded, false}; }
  /// Returns the range above 0, up to `upper`. A number below 1e-9 counts as 0, because nothing
  /// that is measured or set here is as small, and dividing by less could overflow.
  static Range positive(double upper = kUnbounded) { return {kSmallestPositive, upper, false}; }
  /// Returns a range of numbers without a fraction. The type of the bounds is that of the number.
  template <typename Int>
  static Range whole(Int lower, Int upper = std::numeric_limits<Int>::max()) {
    return {static_cast<double>(lower), static_cast<double>(upper), true};
  }

  bool holds(double value) const;

  /// Says what is needed, such as "a number from 0 to 1", "a positive number" or "a whole number of
  /// at least 1". A bound that no file reaches is left out.
  std::string text() const;

 private:
  static constexpr double kSmallestPositive = 1e-9;

  Range(double lower, double upper, bool whole) : lower_(lower), upper_(upper), whole_(whole) {}
  bool is_positive() const { return lower_ == kSmallestPositive; }

  double lower_;
  double upper_;
  bool whole_;
};

/// Lists the numbers of one row of a list of rows, in their order.
class RowFields {
 public:
  void number(double& field, double unit = 1.0, const Range& range = Range::any());
  void whole_number(int& field, int lower, int upper = std::numeric_limits<int>::max());

  std::vector<Range> ranges() const;
  std::vector<double> in_file() const;
  void take(const std::vector<double>& in_file) const;

 private:
  struct Column {
    double* number;  ///< either this
    int* whole;      ///< or this
    double unit;
    Range range;
  };
  std::vector<Column> columns_;
};

/// Visits the fields of a settings struct, to read them from YAML or to write them. One function
/// per struct lists its fields and serves both directions:
///
///     constexpr Named<ServoLaw> kLaws[] = {{ServoLaw::kJacobian, "jacobian"}, ...};
///
///     void list_fields(Fields& fields, ServoSettings& servo) {
///       fields.choice("law", servo.law, kLaws);
///       fields.number("gain", servo.gain, 1.0, Range::positive(1.0));
///       fields.number("settle_ms", servo.settle_s, kMillisecond, Range::at_least(0.0));
///       fields.whole_number("max_iterations", servo.max_iterations, 0, 1000);
///       if (fields.given("path", !servo.path.empty())) fields.text("path", servo.path);
///     }
///
/// YamlReader and YamlWriter visit them. A number in the file times `unit` is the field's value,
/// and ranges are in the file's unit. When reading, a value that breaks its rule is a fault of the
/// file and leaves a number or a word as it was; texts and lists may have been emptied. A function
/// that returns bool returns false then, so that the caller adds no second fault for the same
/// value. Writing changes no field and returns true.
class Fields {
 public:
  Fields() = default;
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;
  virtual ~Fields() = default;

  virtual bool reading() const = 0;
  /// Returns whether to visit a key that a file may leave out: when reading, whether the file has
  /// it; when writing, `wanted`.
  virtual bool given(const std::string& key, bool wanted) = 0;
  /// Returns the keys that a file's map at `key` has, where they are names that a person chose;
  /// none when writing.
  virtual std::vector<std::string> names_in(const std::string& key) = 0;

  bool number(const std::string& key, double& field, double unit = 1.0,
              const Range& range = Range::any());
  template <typename Int>
  bool whole_number(const std::string& key, Int& field, Int lower,
                    Int upper = std::numeric_limits<Int>::max());
  void text(const std::string& key, std::string& field) { word(key, field, {}); }
  void texts(const std::string& key, std::vector<std::string>& field) { words(key, field, 0, {}); }
  /// Visits a text that must be one of `allowed`.
  bool choice(const std::string& key, std::string& field, const std::vector<std::string>& allowed) {
    return word(key, field, allowed);
  }
  /// Visits a value of an enumeration by its name.
  template <typename Value, std::size_t kSize>
  bool choice(const std::string& key, Value& field, const Named<Value> (&table)[kSize]);
  /// Visits a list of values of an enumeration by their names. The list must be as long as the
  /// array.
  template <typename Value, std::size_t kCount, std::size_t kSize>
  bool choices(const std::string& key, std::array<Value, kCount>& field,
               const Named<Value> (&table)[kSize]);

  /// Visits a list of `size` numbers, or of any number of them when `size` is 0.
  bool numbers(const std::string& key, std::vector<double>& field, std::size_t size,
               double unit = 1.0, const Range& range = Range::any());
  /// Visits a list of numbers as long as `field`, which is an array or an Eigen vector of doubles.
  template <typename Array>
  bool numbers(const std::string& key, Array& field, double unit = 1.0,
               const Range& range = Range::any());
  /// Visits a list of numbers that are held in several places; `list_row(RowFields&)` lists them.
  template <typename ListRow>
  bool row(const std::string& key, const ListRow& list_row);
  /// Visits a list of rows of numbers; `list_row(RowFields&, Row&)` lists the numbers of one row. A
  /// vector takes a list of any length, an array one of its own length.
  template <typename Rows, typename ListRow>
  bool rows(const std::string& key, Rows& field, const ListRow& list_row);
  /// Visits such a list whose rows are arrays or Eigen vectors of doubles.
  template <typename Rows>
  bool rows(const std::string& key, Rows& field, double unit = 1.0);

  /// Visits a map; `list_keys()` visits its keys.
  template <typename ListKeys>
  void map(const std::string& key, const ListKeys& list_keys);
  /// Visits a list of maps; `list_keys(Item&)` visits the keys of one. A vector takes a list of any
  /// length, an array one of its own length.
  template <typename Items, typename ListKeys>
  void maps(const std::string& key, Items& field, const ListKeys& list_keys);

  /// Lets the map that is being visited have any keys: where its kind is misspelt, nobody knows
  /// which ones it may have.
  virtual void allow_rest() = 0;

  /// Checks a rule on several fields. When reading, adds the refusal to the faults unless the rule
  /// is `kept`. It stands at the value of `key` or, without a key, at the map that is being
  /// visited. Returns `kept`.
  virtual bool check(bool kept, const Refusal& refusal, const std::string& key = "") = 0;

 protected:
  // The reader and the writer implement the following. Numbers are in the units of the file, and a
  // size of 0 stands for any size. Each text must be one of `allowed`, or any when none are.

  virtual bool word(const std::string& key, std::string& field,
                    const std::vector<std::string>& allowed) = 0;
  virtual bool words(const std::string& key, std::vector<std::string>& field, std::size_t size,
                     const std::vector<std::string>& allowed) = 0;
  virtual bool number_in_file(const std::string& key, double& field, const Range& range) = 0;
  /// Visits a list of numbers, all in the one range or each in its own.
  virtual bool numbers_in_file(const std::string& key, std::vector<double>& field, std::size_t size,
                               const std::vector<Range>& ranges) = 0;
  virtual bool rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                            std::size_t size, const std::vector<Range>& ranges) = 0;
  virtual void begin_map(const std::string& key) = 0;
  /// Begins a list and returns how many items it has. It must have `size` of them when it is
  /// `fixed`.
  virtual std::size_t begin_list(const std::string& key, std::size_t size, bool fixed) = 0;
  virtual void begin_item(std::size_t i) = 0;
  virtual void end_map() = 0;
  virtual void end_list() = 0;

 private:
  template <typename Items>
  static constexpr bool kIsVector = std::is_same_v<Items, std::vector<typename Items::value_type>>;
};

/// Visits the keys translation_mm and quaternion_wxyz of a pose (metres). Returns whether they make
/// a pose: the quaternion must have length 1 to within 0.001, the rounding of a few digits.
bool list_pose(Fields& fields, Pose& pose);

template <typename Int>
bool Fields::whole_number(const std::string& key, Int& field, Int lower, Int upper) {
  auto value = static_cast<double>(field);
  const bool read = number(key, value, 1.0, Range::whole(lower, upper));
  field = static_cast<Int>(value);
  return read;
}

template <typename Value, std::size_t kSize>
bool Fields::choice(const std::string& key, Value& field, const Named<Value> (&table)[kSize]) {
  std::string text = name_in(table, field);
  const bool read = choice(key, text, names_of(table));
  field = value_named(table, text).value();
  return read;
}

template <typename Value, std::size_t kCount, std::size_t kSize>
bool Fields::choices(const std::string& key, std::array<Value, kCount>& field,
                     const Named<Value> (&table)[kSize]) {
  std::vector<std::string> texts;
  texts.reserve(kCount);
  for (const Value value : field) texts.emplace_back(name_in(table, value));
  const bool read = words(key, texts, kCount, names_of(table));
  if (!reading() || !read) return read;
  for (std::size_t i = 0; i < kCount; ++i) field[i] = value_named(table, texts[i]).value();
  return true;
}

template <typename Array>
bool Fields::numbers(const std::string& key, Array& field, double unit, const Range& range) {
  std::vector<double> values(field.begin(), field.end());
  const bool read = numbers(key, values, values.size(), unit, range);
  if (reading() && read) std::copy(values.begin(), values.end(), field.begin());
  return read;
}

template <typename ListRow>
bool Fields::row(const std::string& key, const ListRow& list_row) {
  RowFields fields;
  list_row(fields);
  std::vector<double> values = fields.in_file();
  const bool read = numbers_in_file(key, values, values.size(), fields.ranges());
  if (reading() && read) fields.take(values);
  return read;
}

template <typename Rows, typename ListRow>
bool Fields::rows(const std::string& key, Rows& field, const ListRow& list_row) {
  using Row = typename Rows::value_type;
  const auto fields_of = [&](Row& row) {
    RowFields fields;
    list_row(fields, row);
    return fields;
  };
  Row empty{};
  std::vector<std::vector<double>> values;
  values.reserve(field.size());
  for (Row& row : field) values.push_back(fields_of(row).in_file());
  const std::size_t size = kIsVector<Rows> ? 0 : field.size();
  const bool read = rows_in_file(key, values, size, fields_of(empty).ranges());
  if (!reading() || !read) return read;
  if constexpr (kIsVector<Rows>) field.assign(values.size(), empty);
  for (std::size_t i = 0; i < field.size(); ++i) fields_of(field[i]).take(values[i]);
  return true;
}

template <typename Rows>
bool Fields::rows(const std::string& key, Rows& field, double unit) {
  return rows(key, field, [unit](RowFields& row, typename Rows::value_type& values) {
    for (double& value : values) row.number(value, unit);
  });
}

template <typename ListKeys>
void Fields::map(const std::string& key, const ListKeys& list_keys) {
  begin_map(key);
  list_keys();
  end_map();
}

template <typename Items, typename ListKeys>
void Fields::maps(const std::string& key, Items& field, const ListKeys& list_keys) {
  const std::size_t n = begin_list(key, field.size(), !kIsVector<Items>);
  if constexpr (kIsVector<Items>)
    if (reading()) field.assign(n, {});
  for (std::size_t i = 0; i < n; ++i) {
    begin_item(i);
    list_keys(field[i]);
    end_map();
  }
  end_list();
}

}  // namespace planar
