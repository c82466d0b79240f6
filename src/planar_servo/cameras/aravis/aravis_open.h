#pragma once

#include <arv.h>

#include <string>

#include "planar_servo/cameras/aravis/aravis_call.h"

namespace planar {

/// Opens the GigE Vision camera at `address`; nothing is broadcast. Throws CameraAbsent.
GObjectPtr<ArvCamera> open_gige(const std::string& address);

/// Opens the USB3 Vision camera with this serial number, the first one when it is empty. Throws
/// CameraAbsent when there is none, WorkError when it does not open.
GObjectPtr<ArvCamera> open_usb(const std::string& serial);

}  // namespace planar
