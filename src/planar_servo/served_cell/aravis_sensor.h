#pragma once

#include <arv.h>

#include "planar_servo/served_cell/exposure.h"

namespace planar {

/// Makes Aravis' fake camera show what `exposure` takes: the region of interest, as bright as its
/// exposure time and gain (in dB) make it. The camera's own thread calls `exposure`, which must
/// outlive the camera.
void show_on(ArvFakeCamera* camera, const Exposure& exposure, const cv::Size& sensor_px,
             double frame_rate_hz);

}  // namespace planar
