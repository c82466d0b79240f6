#include "planar_servo/files/matrix_fields.h"

#include <fmt/format.h>

namespace planar {

bool list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points) {
  std::vector<Eigen::Vector2d> rows;
  for (Eigen::Index i = 0; i < points.cols(); ++i) rows.emplace_back(points.col(i));
  if (!fields.rows(key, rows)) return false;
  points.resize(2, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = rows[i];
  return true;
}

void list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points,
                 std::optional<Eigen::Index> size) {
  if (list_points(fields, key, points) && size)
    fields.check(
        points.cols() == *size,
        {fmt::format("{} has {} points", key, points.cols()), fmt::format("{} are needed", *size)},
        key);
}

std::optional<Eigen::Index> list_centers(Fields& fields, Eigen::Matrix2Xd& centers) {
  if (!list_points(fields, "centers_m", centers)) return std::nullopt;
  fields.check(centers.cols() > 0, {"centers_m has no points"}, "centers_m");
  return centers.cols();
}

void add_quality(YamlWriter& yaml, const MapQuality& quality) {
  yaml.add("worth_using", quality.worth_using);
  yaml.add("n_judged", static_cast<int>(quality.n));
  yaml.add("coverage_95", quality.coverage_95);
  if (quality.contradicting > 0.0) yaml.add("contradicting", quality.contradicting);
}

MapQuality read_quality(Fields& figures) {
  constexpr Named<bool> kWorth[] = {{true, "true"}, {false, "false"}};
  MapQuality quality;
  figures.allow_rest();
  if (figures.given("contradicting", false))
    figures.number("contradicting", quality.contradicting, 1.0, Range::from_to(0.0, 1.0));
  if (!figures.given("coverage_95", false)) return quality;
  figures.whole_number("n_judged", quality.n, std::size_t{0});
  figures.choice("worth_using", quality.worth_using, kWorth);
  figures.number("coverage_95", quality.coverage_95, 1.0, Range::from_to(0.0, 1.0));
  return quality;
}

void list_region(Fields& fields, ValidRegion& region) {
  fields.rows("hull_m", region.hull);
  fields.number("hull_margin_m", region.margin, 1.0, Range::at_least(0.0));
}

void list_columns(Fields& fields, const std::string& key, Eigen::MatrixXd& matrix,
                  Eigen::Index rows) {
  std::vector<double> values(matrix.reshaped().begin(), matrix.reshaped().end());
  if (!fields.numbers(key, values, 0) || !fields.reading()) return;
  const auto n = static_cast<Eigen::Index>(values.size());
  if (fields.check(rows > 0 && n % rows == 0,
                   {fmt::format("{} has {} numbers", key, n),
                    fmt::format("a multiple of {} is needed", rows)},
                   key))
    matrix = Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, n / rows);
}

bool list_lower_triangle(Fields& fields, const std::string& key, Eigen::MatrixXd& lower,
                         Eigen::Index size) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < lower.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) values.push_back(lower(i, j));
  const auto n = static_cast<std::size_t>(size * (size + 1) / 2);
  const bool read = fields.numbers(key, values, n);
  if (!fields.reading() || !read) return read;
  lower = Eigen::MatrixXd::Zero(size, size);
  auto value = values.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) lower(i, j) = *value++;
  return true;
}

}  // namespace planar
