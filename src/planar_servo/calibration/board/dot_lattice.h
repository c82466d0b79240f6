#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace planar {

/// Holds the indices of the points that form a lattice of columns x rows, row by row. Every point
/// of the lattice must be there. The order is not mirrored (x turns to y as u turns to v), and the
/// x axis points most to the right among the orientations that the counts allow. Points outside the
/// lattice are ignored, but when a further row or column of it is there too, the lattice is
/// ambiguous and is not found.
struct LatticeFit {
  std::vector<std::size_t> indices;  ///< empty when there is no such lattice
  std::size_t most_found{0};         ///< points of the largest lattice seen
};

/// Finds a lattice among `points`. `sizes` has a length of each point, such as a dot's radius; the
/// search starts between points of like size.
LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, int columns, int rows);

}  // namespace planar
