#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "planar_servo/error_map/map_quality.h"
#include "planar_servo/error_map/maps/valid_region.h"
#include "planar_servo/io/fields.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {

// Fields that several kinds of map files have.

/// Visits points as rows [x, y]. Returns whether they were read.
bool list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points);

/// Visits `size` points as rows [x, y], or any number of them when `size` is not known.
void list_points(Fields& fields, const std::string& key, Eigen::Matrix2Xd& points,
                 std::optional<Eigen::Index> size);

/// Visits the centres and returns how many there are. Empty when they could not be read.
std::optional<Eigen::Index> list_centers(Fields& fields, Eigen::Matrix2Xd& centers);

/// Adds to the figures of a fit what places left out say of its map.
void add_quality(YamlWriter& yaml, const MapQuality& quality);

/// Reads that back. A file of an earlier version does not have it, and nothing judges its map then.
MapQuality read_quality(Fields& figures);

void list_region(Fields& fields, ValidRegion& region);

/// Visits a matrix of so many rows and any number of columns, column after column.
void list_columns(Fields& fields, const std::string& key, Eigen::MatrixXd& matrix,
                  Eigen::Index rows);

/// Visits the lower triangle of a matrix of so many rows, row after row.
void list_factor(Fields& fields, Eigen::MatrixXd& lower, Eigen::Index size);

}  // namespace planar
