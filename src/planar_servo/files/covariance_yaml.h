#pragma once

#include <Eigen/Core>

#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {

/// Adds `covariance:`, one row a line, of the variables named by `covariance_of:`.
void add_covariance(YamlWriter& writer, const std::vector<std::string>& variables,
                    const Eigen::MatrixXd& covariance);

/// Reads it back; faults unless it is of that size, symmetric, and no variance is negative.
Eigen::MatrixXd read_covariance(const YamlNode& root, std::size_t size);

}  // namespace planar
