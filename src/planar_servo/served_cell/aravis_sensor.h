#pragma once

#include <arv.h>

#include "planar_servo/served_cell/exposure.h"

namespace planar {

/// Makes Aravis' fake camera, a set of registers with a source of pictures, show what `exposure`
/// takes: of its region of interest, by its exposure time and gain (in dB). `exposure` is called by
/// the camera's own thread and must outlive it.
void show_on(ArvFakeCamera* camera, const Exposure& exposure, const cv::Size& sensor_px,
             double frame_rate_hz);

}  // namespace planar
