#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "planar_servo/io/fields.h"

namespace planar {

/// Visits the keys covariance_of (the names of its variables, which tell a reader their units and
/// are not read) and covariance, a symmetric matrix row by row.
template <int kSize>
void list_covariance(Fields& fields, const std::vector<std::string>& variables,
                     Eigen::Matrix<double, kSize, kSize>& covariance) {
  std::vector<std::string> names = variables;
  if (fields.given("covariance_of", true)) fields.texts("covariance_of", names);
  using Row = Eigen::Matrix<double, kSize, 1>;
  std::array<Row, kSize> rows;
  for (int i = 0; i < kSize; ++i) rows[i] = covariance.row(i);
  const bool read = fields.rows("covariance", rows, [](RowFields& row, Row& values) {
    for (double& value : values) row.number(value);
  });
  if (!fields.reading() || !read) return;
  for (int i = 0; i < kSize; ++i) covariance.row(i) = rows[i];
  fields.check(
      covariance.isApprox(covariance.transpose()) && (covariance.diagonal().array() >= 0.0).all(),
      "covariance must be symmetric, with variances of 0 or more on its diagonal", "covariance");
}

}  // namespace planar
