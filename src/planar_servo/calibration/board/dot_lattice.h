#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace planar {

/// Indices of `points` that form a lattice of columns x rows, row by row: every point of it, not
/// mirrored (x turns to y as u turns to v) and with the x axis most to the right among the
/// orientations that the counts allow. Points outside the lattice are ignored, but when a further
/// row or column of it is there too, the lattice is ambiguous.
struct LatticeFit {
  std::vector<std::size_t> indices;  ///< empty when there is no such lattice
  std::size_t most_found{0};         ///< points of the largest lattice seen
};

/// `sizes`: a length of each point (a dot's radius); a lattice starts between points of like size.
LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, int columns, int rows);

}  // namespace planar
