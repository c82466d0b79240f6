#pragma once

#include <opencv2/core.hpp>

#include "marker/blob.h"
#include "marker/lamp.h"

namespace planar {

/// Measures the centre of the lamp that a blob of the image has announced; pixels of the image.
/// kCannyKasa: Canny pixels, grey moments, Kasa's circle (the paper). kVpDot2: the centre of
/// gravity of vpDot2's contour. kAuto: the same grey-moment edges, an ellipse or circle fitted to
/// them by distances without the outliers, its covariance; kNotRound when edges are missing over a
/// wide angle. A status other than kOk comes with the blob's centroid and no covariance.
LampCenter measure_lamp(const cv::Mat& image, const Blob& blob, CenterMethod method);

}  // namespace planar
