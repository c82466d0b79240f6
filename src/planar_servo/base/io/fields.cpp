#include "planar_servo/base/io/fields.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

bool is_told(double bound) {
  return std::abs(bound) < Range::kUnbounded && std::abs(bound) != std::numeric_limits<int>::max();
}

}  // namespace

bool Range::holds(double value) const {
  return value >= lower_ && value <= upper_ && (!whole_ || value == std::trunc(value));
}

std::string Range::text() const {
  const bool from = is_told(lower_) && !is_positive(), to = is_told(upper_);
  if (!from && !to && !is_positive() && !whole_) return "a finite number";
  std::string number = is_positive() ? "a positive number" : whole_ ? "a whole number" : "a number";
  if (from && to) return fmt::format("{} from {} to {}", number, lower_, upper_);
  if (from) return fmt::format("{} of at least {}", number, lower_);
  if (to) return fmt::format("{} of at most {}", number, upper_);
  return number;
}

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

bool Fields::number(const std::string& key, double& field, double unit, const Range& range) {
  double in_file = field / unit;
  const bool read = number_in_file(key, in_file, range);
  if (reading() && read) field = in_file * unit;
  return read;
}

bool Fields::numbers(const std::string& key, std::vector<double>& field, std::size_t size,
                     double unit, const Range& range) {
  std::vector<double> in_file = field;
  for (double& value : in_file) value /= unit;
  const bool read = numbers_in_file(key, in_file, size, {range});
  if (!reading() || !read) return read;
  field = std::move(in_file);
  for (double& value : field) value *= unit;
  return true;
}

bool list_pose(Fields& fields, Pose& pose) {
  constexpr double kRounding = 1e-3;
  const Eigen::Quaterniond q(pose.linear());
  Eigen::Vector3d translation = pose.translation();
  Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
  bool read = fields.numbers("translation_mm", translation, kMillimetre);
  read = fields.numbers("quaternion_wxyz", wxyz) &&
         fields.check(std::abs(wxyz.norm() - 1.0) <= kRounding,
                      {"quaternion_wxyz must have length 1"}, "quaternion_wxyz") &&
         read;
  if (!fields.reading() || !read) return read;
  pose.translation() = translation;
  pose.linear() =
      Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
  return true;
}

}  // namespace planar
