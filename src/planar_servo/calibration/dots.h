#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace planar {

/// Describes a round dot as an image shows it: the ellipse {center + shape * (cos t, sin t)}, in
/// pixels.
struct Dot {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();
  /// Standard deviation of the measured centre per axis, from the scatter of the outline.
  double sigma{0.0};

  double area() const;
};

/// Finds all dark blobs of about elliptic outline in an 8-bit grey image, to about half a pixel.
std::vector<Dot> find_dark_dots(const cv::Mat& image);

/// Measures the dot's ellipse to a few hundredths of a pixel. Along rays from its centre it finds
/// where the grey level crosses the middle between dot and surroundings, and fits an ellipse to
/// these points, leaving out outliers. Each ray has grey levels of its own, so that shading does
/// not shift the outline. Empty when there is no such outline.
std::optional<Dot> measure_dot(const cv::Mat& image, const Dot& rough);

/// Holds the indices of the points that form a lattice of columns x rows, row by row. Every point
/// of the lattice must be there. The order is not mirrored (x turns to y as u turns to v), and the
/// x axis points most to the right among the orientations that the counts allow. Points outside the
/// lattice are ignored, but a lattice with a further row or column is ambiguous and is not found.
struct LatticeFit {
  std::vector<std::size_t> indices;  ///< empty when there is no such lattice
  std::size_t most_found{0};         ///< points of the largest lattice seen
};

/// Finds a lattice among `points`. `sizes` holds a length for each point, such as a dot's radius;
/// the search starts between points of similar size.
LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, int columns, int rows);

}  // namespace planar
