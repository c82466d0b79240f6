#include "planar_servo/calibration/board/dot_grid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "planar_servo/calibration/board/dot.h"
#include "planar_servo/calibration/board/dot_lattice.h"

namespace planar {
namespace {

/// Longest side of the first image in which dots are looked for; then twice that, and so on.
constexpr int kFirstSize_px = 1280;

struct RoughGrid {
  std::vector<Dot> dots;  ///< row by row, in pixels of the full image; empty when not found
  std::size_t most_found{0};
};

Dot enlarged(const Dot& dot, double factor) {
  const Eigen::Vector2d half(0.5, 0.5);  // pixel centres are at whole numbers
  return {factor * (dot.center + half) - half, factor * dot.shape};
}

RoughGrid find_dark_grid(const cv::Mat& image, int columns, int rows, int factor) {
  cv::Mat small = image;
  if (factor > 1) cv::resize(image, small, {}, 1.0 / factor, 1.0 / factor, cv::INTER_AREA);
  const std::vector<Dot> dots = find_dark_dots(small);
  std::vector<Eigen::Vector2d> centers;
  std::vector<double> sizes;
  for (const Dot& dot : dots) {
    centers.push_back(dot.center);
    sizes.push_back(std::sqrt(dot.area()));
  }
  const LatticeFit lattice = find_lattice(centers, sizes, columns, rows);
  RoughGrid grid;
  grid.most_found = lattice.most_found;
  for (const std::size_t i : lattice.indices) grid.dots.push_back(enlarged(dots[i], factor));
  return grid;
}

/// Searches the coarsest image first, and each image for dark dots before bright ones.
RoughGrid find_rough_grid(const cv::Mat& image, int columns, int rows) {
  int factor = 1;
  while (std::max(image.cols, image.rows) > kFirstSize_px * factor) factor *= 2;
  std::size_t most_found = 0;
  for (; factor >= 1; factor /= 2) {
    for (const bool bright : {false, true}) {
      const cv::Mat shown = bright ? cv::Mat(255 - image) : image;
      RoughGrid grid = find_dark_grid(shown, columns, rows, factor);
      if (!grid.dots.empty()) return grid;
      most_found = std::max(most_found, grid.most_found);
    }
  }
  return {{}, most_found};
}

}  // namespace

BoardSight find_dot_grid(const cv::Mat& image, int columns, int rows) {
  const RoughGrid rough = find_rough_grid(image, columns, rows);
  const std::string wanted = std::to_string(columns) + " x " + std::to_string(rows) + " dots";
  BoardSight sight;
  if (rough.dots.empty()) {
    sight.reason = "no grid of " + wanted + " found (" + std::to_string(rough.most_found) +
                   " dots in the largest lattice)";
    sight.dots_in_a_grid = rough.most_found;
    return sight;
  }
  for (const Dot& dot : rough.dots) {
    const auto measured = measure_dot(image, dot);
    if (!measured) return {{}, {}, {}, "one of the " + wanted + " has no clear outline"};
    sight.pixels.push_back(measured->center);
    sight.dot_areas_px2.push_back(measured->area());
    sight.dot_sigmas_px.push_back(measured->sigma);
  }
  return sight;
}

}  // namespace planar
