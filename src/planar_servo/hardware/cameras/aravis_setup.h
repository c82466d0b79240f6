#pragma once

#include <arv.h>
#include <glib-object.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"

namespace planar {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <typename T>
using GObjectPtr = std::unique_ptr<T, Unref>;

/// Makes a call that reports failure by GError, and throws that as a WorkError behind `what`.
template <typename Call>
auto ask(const std::string& what, Call call, const std::string& remedy = "") {
  GError* error = nullptr;
  const auto refuse = [&] {
    if (error == nullptr) return;
    const std::string message = error->message;
    g_error_free(error);
    throw WorkError({what + ": " + message, remedy, "", Cause::kDevice});
  };
  if constexpr (std::is_void_v<decltype(call(&error))>) {
    call(&error);
    refuse();
  } else {
    const auto answer = call(&error);
    refuse();
    return answer;
  }
}

// All of these throw WorkError when the camera does not answer or refuses.

ArvPixelFormat arv_format(PixelFormat format);

/// Returns maker, model, firmware and serial number, as far as the camera tells them.
std::string identity_of(ArvCamera* camera);

/// Throws unless the camera has the sensor size of the settings and, on GigE, their serial number;
/// where they name none, it becomes theirs. (On USB, the number by which a camera is found may be
/// written otherwise in the camera itself.)
void require_identity(ArvCamera* camera, AravisSettings& settings);

/// Undoes what a camera does to its pictures before it sends them: gamma, look-up tables,
/// sharpening, binning, mirroring, test patterns, automatic black level. Returns what it changed,
/// such as "Gamma was 0.45 and is 1". Throws for a feature that the camera keeps.
std::vector<std::string> make_plain(ArvCamera* camera);

/// Sets pixel format, exposure, gain, trigger, strobe and packet size.
void apply_settings(ArvCamera* camera, const AravisSettings& settings);

/// Sets the strobe's line to light while the camera exposes, or never.
void apply_strobe(ArvCamera* camera, const CameraStrobe& strobe, bool on);

/// A feature by its name in the camera (GenICam's SFNC), and its value as text.
using CameraFeature = std::pair<std::string, std::string>;

/// Returns those features on which pictures depend, as far as the camera has them.
std::vector<CameraFeature> picture_features(ArvCamera* camera);

/// Throws when a feature has another value now than it had then.
void require_unchanged(ArvCamera* camera, const CameraFeature& then);

void apply_exposure(ArvCamera* camera, const CameraExposure& exposure);

/// Opens the GigE Vision camera at `address` without any broadcast, and waits some seconds while
/// another program controls it. Throws WorkError when none answers, and when that program stays.
GObjectPtr<ArvCamera> open_gige(const std::string& address);

/// Opens the USB3 Vision camera with this serial number in its USB descriptor, or the first one,
/// whose number `serial` becomes, when that is empty. Throws WorkError when there is none or it
/// does not open.
GObjectPtr<ArvCamera> open_usb(std::string& serial);

}  // namespace planar
