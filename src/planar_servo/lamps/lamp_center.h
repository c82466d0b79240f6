#pragma once

#include <opencv2/core.hpp>

#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/vp_dot_tracker.h"

namespace planar {

/// Measures the centre of the lamp that a blob of the image has announced; pixels of the image.
/// kCannyKasa: Canny pixels, grey moments, Kasa's circle (the paper). kVpDot2: the centre of
/// gravity of vpDot2's contour. kFast: the centroid of the light, for even lamps only. kAuto: the
/// outline fitted to the grey levels (see fit_rim), kNotRound when more than 100 degrees of the rim
/// do not belong to it. A status other than kOk comes with the blob's centroid and no covariance.
LampCenter measure_lamp(const cv::Mat& image, const Blob& blob, CenterMethod method);

/// The lamp that vpDot2 follows, as kVpDot2 measures it.
LampCenter lamp_at_dot(const cv::Mat& image, const VpDot& dot);

}  // namespace planar
