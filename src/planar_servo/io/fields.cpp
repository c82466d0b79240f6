#include "planar_servo/io/fields.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "planar_servo/core/units.h"

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
  const bool read = numbers_in_file(key, in_file, size, range);
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
