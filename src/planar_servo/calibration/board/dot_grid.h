#pragma once

#include <opencv2/core.hpp>

#include "planar_servo/calibration/board/board.h"

namespace planar {

/// Finds a grid of columns x rows round dots, dark on bright or bright on dark, in an 8-bit grey
/// image: dots in a reduced image, their lattice grown from one dot to its neighbours, each centre
/// then measured in the full image (see measure_dot). Other marks may be about, but no further row
/// of dots.
BoardSight find_dot_grid(const cv::Mat& image, int columns, int rows);

}  // namespace planar
