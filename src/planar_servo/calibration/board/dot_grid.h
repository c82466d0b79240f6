#pragma once

#include <opencv2/core.hpp>

#include "planar_servo/calibration/board/board.h"

namespace planar {

/// Finds a grid of columns x rows round dots, dark on bright or bright on dark, in an 8-bit grey
/// image. It finds dots in a reduced image, grows their lattice from one dot to its neighbours, and
/// then measures each centre in the full image (see measure_dot()). The image may show other marks,
/// but no further row of dots.
BoardSight find_dot_grid(const cv::Mat& image, int columns, int rows);

}  // namespace planar
