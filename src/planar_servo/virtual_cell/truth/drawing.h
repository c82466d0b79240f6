#pragma once

#include <Eigen/Core>

#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Draws a number whose magnitude lies in the range, of either sign.
double either_sign(Random& random, double lower, double upper);

/// Draws a number within 30 % of the median.
double near_median(Random& random, double median);

/// Draws a vector of any direction whose length lies in the range.
Eigen::Vector2d any_direction(Random& random, double lower, double upper);

/// Draws a harmonic of any phase whose amplitude lies in the range.
Harmonic harmonic(Random& random, int order, double lower, double upper);

/// Draws the length by which something is off, metres: 0 except for the share of outliers.
double stray_length(const OutlierTruth& outliers, Random& random);

}  // namespace planar
