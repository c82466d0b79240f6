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

/// The lattice that is wanted.
struct LatticeForm {
  std::vector<Eigen::Vector2i> places;  ///< row by row, in steps along x and y from the first one
  bool diagonal{false};  ///< the nearest places are those one step along both x and y
};

/// Holds the points that form a lattice, row by row. The order is not mirrored (x turns to y as u
/// turns to v), and the x axis points most to the right among the orientations that the form
/// allows. Points outside the lattice are ignored, but one with a further row or column is
/// ambiguous and is not found. Of one that is not whole, at least half is there, and at least one
/// point of every outer row and column.
struct LatticeFit {
  std::vector<std::size_t> indices;  ///< of points; empty when there is no such lattice
  std::vector<std::size_t> places;   ///< which places of the form they take
  std::size_t most_found{0};         ///< points of the largest lattice seen
};

/// Finds a lattice among `points`. `sizes` holds a length for each point, such as a dot's radius;
/// neighbours are of similar size.
LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, const LatticeForm& form);

}  // namespace planar
