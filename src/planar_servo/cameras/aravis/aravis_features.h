#pragma once

#include <arv.h>

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/cameras/aravis/pixel_format.h"
#include "planar_servo/devices/frame_source.h"

namespace planar {

// All of these throw WorkError when the camera does not answer or refuses.

ArvPixelFormat arv_format(PixelFormat format);

/// Throws unless the camera has the serial number and sensor size of the settings.
void require_identity(ArvCamera* camera, const AravisSettings& settings);

/// Sets pixel format, exposure, gain, trigger and packet size.
void apply_settings(ArvCamera* camera, const AravisSettings& settings);

void apply_exposure(ArvCamera* camera, const CameraExposure& exposure);

}  // namespace planar
