#pragma once

#include <arv.h>

#include "devices/frame_source.h"
#include "frame_source/aravis_settings.h"
#include "frame_source/pixel_format.h"

namespace planar {

// All of these throw WorkError when the camera does not answer or refuses.

ArvPixelFormat arv_format(PixelFormat format);

/// Throws unless the camera has the serial number and the sensor of the settings.
void require_identity(ArvCamera* camera, const AravisSettings& settings);

/// Pixel format, exposure, gain, trigger and packet size.
void apply_settings(ArvCamera* camera, const AravisSettings& settings);

void apply_exposure(ArvCamera* camera, const CameraExposure& exposure);

}  // namespace planar
