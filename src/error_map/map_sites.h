#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "error_map/error_sample.h"

namespace planar {

/// Calibration points at distinct positions, as columns of matrices.
struct MapSites {
  Eigen::Matrix2Xd positions;  ///< metres
  Eigen::Matrix2Xd errors;     ///< mean error of the samples at each position, metres
  std::vector<std::vector<std::size_t>> samples;  ///< which samples were merged into each

  Eigen::Index size() const { return positions.cols(); }
  MapSites subset(const std::vector<Eigen::Index>& kept) const;
  std::size_t sample_count() const;
};

/// Merges samples closer together than any camera can tell apart. Throws InputError naming each
/// sample that is not finite, or when fewer than three distinct positions remain.
MapSites merge_samples(const std::vector<ErrorSample>& samples);

}  // namespace planar
