#pragma once

#include <arv.h>

#include <string>

#include "planar_servo/cameras/aravis/aravis_call.h"

namespace planar {

/// Opens the GigE Vision camera at `address` without any broadcast, and waits some seconds while
/// another program controls it. Throws WorkError when none answers, and when that program stays.
GObjectPtr<ArvCamera> open_gige(const std::string& address);

/// Opens the USB3 Vision camera with this serial number, or the first one when `serial` is empty.
/// Throws WorkError when there is none or it does not open.
GObjectPtr<ArvCamera> open_usb(const std::string& serial);

}  // namespace planar
