#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/io/fields.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/error_map/error_sample.h"

namespace planar {

/// Returns a file's text by `program`, made from `origins`, with the fields that `list` visits.
template <typename Record>
std::string record_text(const char* kind, Record record, const std::vector<Origin>& origins,
                        const std::string& program, void (*list)(Fields&, Record&)) {
  YamlWriter yaml(kind, program);
  yaml.add_inputs(input_records(origins));
  list(yaml, record);
  return yaml.text();
}

/// Reads such a file. Throws InputError naming every fault.
template <typename Record>
Record read_record(const char* kind, const std::filesystem::path& path,
                   void (*list)(Fields&, Record&)) {
  YamlReader reader(path, kind);
  Record record;
  list(reader, record);
  reader.throw_if_faulty();
  return record;
}

// Fields that several files of a calibration have: points, matrices and what judges a map.

/// Visits points as rows [x, y]. Returns whether they were read.
bool list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points);

/// Visits `size` points as rows [x, y], or any number of them when `size` is not known.
void list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points,
                 std::optional<Eigen::Index> size);

/// Visits the centres and returns how many there are. Empty when they could not be read.
std::optional<Eigen::Index> list_centers(Fields& fields, Eigen::Matrix2Xd& centers);

/// Adds to the figures of a fit how its map does at places left out.
void add_quality(YamlWriter& yaml, const MapQuality& quality);

/// Reads that back. A file of an earlier version does not have it, and nothing judges its map then.
MapQuality read_quality(Fields& figures);

void list_region(Fields& fields, ValidRegion& region);

/// Visits a matrix of so many rows and any number of columns, column after column.
void list_columns(Fields& fields, const std::string& key, Eigen::MatrixXd& matrix,
                  Eigen::Index rows);

/// Visits the lower triangle of a matrix of so many rows, row after row. When it was read, zeros
/// stand above it. Returns whether it was read.
bool list_lower_triangle(Fields& fields, const std::string& key, Eigen::MatrixXd& lower,
                         Eigen::Index size);

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
  const bool read = fields.rows("covariance", rows);
  if (!fields.reading() || !read) return;
  for (int i = 0; i < kSize; ++i) covariance.row(i) = rows[i];
  fields.check(
      covariance.isApprox(covariance.transpose()) && (covariance.diagonal().array() >= 0.0).all(),
      {"covariance must be symmetric, with variances of 0 or more on its diagonal"}, "covariance");
}

}  // namespace planar
