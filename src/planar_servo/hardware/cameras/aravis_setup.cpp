#include "planar_servo/hardware/cameras/aravis_setup.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <optional>

#include "planar_servo/base/core/clock.h"

namespace planar {
namespace {

template <typename GetBounds>
void require_within(ArvCamera* camera, const char* what, double value, const char* unit,
                    GetBounds get_bounds) {
  double least = 0.0, most = 0.0;
  ask(fmt::format("the camera does not report the bounds of {}", what),
      [&](GError** e) { get_bounds(camera, &least, &most, e); });
  if (value < least || value > most)
    throw WorkError(fmt::format("the camera refuses {} of {:.6g} {}; it can do {:.6g} to {:.6g} {}",
                                what, value, unit, least, most, unit),
                    Cause::kInvalid);
}

void apply_picture(ArvCamera* camera, const AravisSettings& settings) {
  const PixelFormat format = settings.pixel_format;
  ask(fmt::format("the camera refuses the pixel format {}", name_in(kPixelFormats, format)),
      [&](GError** e) { arv_camera_set_pixel_format(camera, arv_format(format), e); });
  const auto automatic_off = [&](const char* what, auto available, auto set) {
    if (!ask(what, [&](GError** e) { return available(camera, e); })) return;
    ask(what, [&](GError** e) { set(camera, ARV_AUTO_OFF, e); });
  };
  automatic_off("the camera does not switch its automatic exposure off",
                arv_camera_is_exposure_auto_available, arv_camera_set_exposure_time_auto);
  automatic_off("the camera does not switch its automatic gain off",
                arv_camera_is_gain_auto_available, arv_camera_set_gain_auto);
  apply_exposure(camera, {settings.exposure_s, settings.gain_db});
}

/// Sets the first of the features that the camera has to a word of an enumeration or a number.
template <typename Value>
void set_first(ArvCamera* camera, std::initializer_list<const char*> features, const Value& value) {
  ArvDevice* const device = arv_camera_get_device(camera);
  for (const char* feature : features) {
    if (arv_device_get_feature(device, feature) == nullptr) continue;
    ask(fmt::format("the camera refuses {} as {}", value, feature), [&](GError** e) {
      if constexpr (std::is_same_v<Value, double>)
        arv_device_set_float_feature_value(device, feature, value, e);
      else
        arv_device_set_string_feature_value(device, feature, std::string(value).c_str(), e);
    });
    return;
  }
  throw WorkError({fmt::format("the camera has no {}, which its strobe needs", *features.begin()),
                   "leave out camera.strobe, or of it delay_us and duration_us", "",
                   Cause::kMissing});
}

/// Returns the first of the words that a feature can take which begins with `stem`.
std::string word_of(ArvCamera* camera, const char* feature, const std::string& stem) {
  guint n = 0;
  const std::unique_ptr<const char*, void (*)(gpointer)> words(
      ask(fmt::format("the camera does not list the values of {}", feature),
          [&](GError** e) {
            return arv_device_dup_available_enumeration_feature_values_as_strings(
                arv_camera_get_device(camera), feature, &n, e);
          }),
      g_free);
  for (guint i = 0; i < n; ++i)
    if (std::string word = words.get()[i]; word.rfind(stem, 0) == 0) return word;
  throw WorkError(fmt::format("the camera's {} cannot be {}", feature, stem), Cause::kMissing);
}

void apply_trigger(ArvCamera* camera, const AravisSettings& settings) {
  if (settings.trigger == CameraTrigger::kFreeRun) {
    ask("the camera refuses to run without a trigger",
        [&](GError** e) { arv_camera_clear_triggers(camera, e); });
    ask(fmt::format("the camera refuses {:.4g} frames/s", settings.frame_rate_hz),
        [&](GError** e) { arv_camera_set_frame_rate(camera, settings.frame_rate_hz, e); });
    return;
  }
  const std::string source = settings.trigger == CameraTrigger::kSoftware
                                 ? "Software"
                                 : word_of(camera, "TriggerSource", "Line");
  ask("the camera refuses the trigger " + source,
      [&](GError** e) { arv_camera_set_trigger(camera, source.c_str(), e); });
}

void apply_packet_size(ArvCamera* camera, const AravisSettings& settings) {
  if (settings.packet_size == 0) return;  // Aravis finds the largest size that passes
  arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  ask(fmt::format("the camera refuses packets of {} bytes", settings.packet_size),
      [&](GError** e) { arv_camera_gv_set_packet_size(camera, settings.packet_size, e); });
}

/// A camera obeys one program at a time. By the standard's default [GigE Vision 2.0,
/// GevHeartbeatTimeout] it waits this long for a sign of life from a program that ended without
/// closing it; seconds.
constexpr double kLeave_s = 3.0;
constexpr double kPatience_s = kLeave_s + 1.0, kPoll_s = 0.2;

void take_control(ArvDevice* device, const std::string& address) {
  SteadyClock clock;
  const double end_s = clock.now_s() + kPatience_s;
  while (arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == FALSE) {
    if (clock.now_s() > end_s)
      throw WorkError({"another program controls the GigE camera at " + address,
                       "end that program; a camera obeys one at a time", "", Cause::kBusy});
    clock.sleep_for_s(kPoll_s);
    GError* refusal = nullptr;
    arv_gv_device_take_control(ARV_GV_DEVICE(device), &refusal);
    g_clear_error(&refusal);
  }
}

GObjectPtr<ArvDevice> reach_gige(const std::string& address) {
  const std::string local = local_address_towards(address);
  const GObjectPtr<GInetAddress> ours(g_inet_address_new_from_string(local.c_str()));
  const GObjectPtr<GInetAddress> theirs(g_inet_address_new_from_string(address.c_str()));
  return GObjectPtr<ArvDevice>(ask(
      "no GigE camera answers at " + address,
      [&](GError** e) { return arv_gv_device_new(ours.get(), theirs.get(), e); },
      fmt::format("ping {0}; if nothing answers, check that the camera has power and that this "
                  "machine has an address in its network (ip route get {0})",
                  address)));
}

/// What leaves the pixels as the sensor has them, by the names of GenICam's SFNC; a camera has
/// some. Edges of lamps are fitted to levels that are linear in light, and places to the whole
/// sensor.
constexpr std::pair<const char*, const char*> kPlain[] = {
    {"LUTEnable", "false"},        {"GammaEnable", "false"},      {"Gamma", "1"},
    {"SharpnessEnable", "false"},  {"SharpeningEnable", "false"}, {"BlackLevelAuto", "Off"},
    {"BalanceWhiteAuto", "Off"},   {"BinningHorizontal", "1"},    {"BinningVertical", "1"},
    {"DecimationHorizontal", "1"}, {"DecimationVertical", "1"},   {"ReverseX", "false"},
    {"ReverseY", "false"},         {"TestPattern", "Off"},        {"TestImageSelector", "Off"},
    {"ChunkModeActive", "false"}};

/// What else pictures depend on, by the names of SFNC and of older cameras.
constexpr const char* kOfPictures[] = {
    "PixelFormat", "ExposureAuto", "ExposureTime",  "ExposureTimeAbs", "GainAuto",     "Gain",
    "GainRaw",     "BlackLevel",   "BlackLevelRaw", "TriggerMode",     "TriggerSource"};

/// Returns a feature's value as text; empty where the camera does not have it, or not now.
std::optional<std::string> value_of(ArvGcNode* node) {
  GError* ignored = nullptr;
  std::optional<std::string> value;
  if (node != nullptr && ARV_IS_GC_FEATURE_NODE(node) &&
      arv_gc_feature_node_is_available(ARV_GC_FEATURE_NODE(node), &ignored) != FALSE) {
    const char* const text =
        arv_gc_feature_node_get_value_as_string(ARV_GC_FEATURE_NODE(node), &ignored);
    if (ignored == nullptr && text != nullptr) value = text;
  }
  g_clear_error(&ignored);
  return value;
}

bool same_value(const std::string& a, const std::string& b) {
  char *end_a = nullptr, *end_b = nullptr;
  const double number_a = std::strtod(a.c_str(), &end_a), number_b = std::strtod(b.c_str(), &end_b);
  constexpr double kRounding = 1e-3;
  if (end_a != a.c_str() && end_b != b.c_str()) return std::abs(number_a - number_b) < kRounding;
  return a == b;
}

}  // namespace

std::vector<std::string> make_plain(ArvCamera* camera) {
  std::vector<std::string> changed;
  for (const auto& [name, plain] : kPlain) {
    ArvGcNode* const node = arv_device_get_feature(arv_camera_get_device(camera), name);
    const auto before = value_of(node);
    if (!before || same_value(*before, plain)) continue;
    GError* refusal = nullptr;
    arv_gc_feature_node_set_value_from_string(ARV_GC_FEATURE_NODE(node), plain, &refusal);
    const std::string why = refusal != nullptr ? fmt::format(" ({})", refusal->message) : "";
    g_clear_error(&refusal);
    const auto after = value_of(node);
    if (after && !same_value(*after, plain))
      throw WorkError(
          {fmt::format("the camera keeps {} at {}, where {} is needed{}", name, *after, plain, why),
           "set it by the maker's program, and save it as the camera's default", "",
           Cause::kDevice});
    changed.push_back(fmt::format("{} was {} and is {}", name, *before, plain));
  }
  return changed;
}

std::vector<CameraFeature> picture_features(ArvCamera* camera) {
  std::vector<CameraFeature> features;
  const auto add = [&](const char* name) {
    if (const auto value = value_of(arv_device_get_feature(arv_camera_get_device(camera), name)))
      features.emplace_back(name, *value);
  };
  for (const char* name : kOfPictures) add(name);
  for (const auto& plain : kPlain) add(plain.first);
  return features;
}

void require_unchanged(ArvCamera* camera, const CameraFeature& then) {
  const auto& [name, value] = then;
  const auto now = value_of(arv_device_get_feature(arv_camera_get_device(camera), name.c_str()));
  if (now && !same_value(*now, value))
    throw WorkError(
        {fmt::format("its {} is {} and was {}: another program has changed it", name, *now, value),
         "end that program; a camera obeys one at a time", "", Cause::kBusy});
}

ArvPixelFormat arv_format(PixelFormat format) {
  // Aravis has no name for two of these numbers of GenICam's convention.
  constexpr ArvPixelFormat kMono10p = 0x010a0046, kMono12p = 0x010c0047;
  constexpr ArvPixelFormat kFormats[] = {
      ARV_PIXEL_FORMAT_MONO_8,         ARV_PIXEL_FORMAT_MONO_10, kMono10p,
      ARV_PIXEL_FORMAT_MONO_10_PACKED, ARV_PIXEL_FORMAT_MONO_12, kMono12p,
      ARV_PIXEL_FORMAT_MONO_12_PACKED};
  return kFormats[static_cast<std::size_t>(format)];
}

std::string identity_of(ArvCamera* camera) {
  std::string who;
  for (const auto& [words, feature] :
       {std::pair("", "DeviceVendorName"), std::pair(" ", "DeviceModelName"),
        std::pair(", firmware ", "DeviceFirmwareVersion"), std::pair(", version ", "DeviceVersion"),
        std::pair(", serial number ", "DeviceSerialNumber")}) {
    GError* ignored = nullptr;
    const char* const told =
        arv_device_get_string_feature_value(arv_camera_get_device(camera), feature, &ignored);
    if (ignored == nullptr && told != nullptr) who += std::string(words) + told;
    g_clear_error(&ignored);
  }
  return who;
}

void require_identity(ArvCamera* camera, AravisSettings& settings) {
  if (!settings.address.empty()) {
    GError* ignored = nullptr;
    const char* const told = arv_camera_get_device_serial_number(camera, &ignored);
    const std::string serial = ignored == nullptr && told != nullptr ? told : "";
    g_clear_error(&ignored);
    if (settings.id.empty()) settings.id = serial;
    if (serial != settings.id)
      throw WorkError(fmt::format("the camera at {} has the serial number {}, not {}",
                                  settings.address, serial, settings.id),
                      Cause::kForeign);
  }
  cv::Size sensor;
  ask("the camera does not report its sensor size",
      [&](GError** e) { arv_camera_get_sensor_size(camera, &sensor.width, &sensor.height, e); });
  if (sensor != settings.sensor_px)
    throw WorkError(
        fmt::format("the camera's sensor has {} x {} pixels; the cell says {} x {}", sensor.width,
                    sensor.height, settings.sensor_px.width, settings.sensor_px.height),
        Cause::kContradiction);
}

void apply_settings(ArvCamera* camera, const AravisSettings& settings) {
  apply_picture(camera, settings);
  apply_trigger(camera, settings);
  if (settings.strobe) apply_strobe(camera, *settings.strobe, true);
  if (arv_camera_is_gv_device(camera)) apply_packet_size(camera, settings);
}

void apply_strobe(ArvCamera* camera, const CameraStrobe& strobe, bool on) {
  const bool is_timed = strobe.delay_s > 0.0 || strobe.duration_s > 0.0;
  set_first(camera, {"LineSelector"}, strobe.line);
  set_first(camera, {"LineMode"}, "Output");
  std::string source = on ? "ExposureActive" : "Off";
  if (on && is_timed) {
    const std::string timer = word_of(camera, "TimerSelector", "Timer");
    set_first(camera, {"TimerSelector"}, timer);
    set_first(camera, {"TimerTriggerSource"}, "ExposureStart");
    set_first(camera, {"TimerDelay", "TimerDelayAbs"}, 1e6 * strobe.delay_s);
    set_first(camera, {"TimerDuration", "TimerDurationAbs"}, 1e6 * strobe.duration_s);
    source = word_of(camera, "LineSource", timer);
  }
  set_first(camera, {"LineSource"}, source);
}

void apply_exposure(ArvCamera* camera, const CameraExposure& exposure) {
  const double time_us = 1e6 * exposure.time_s;
  require_within(camera, "an exposure", time_us, "us", arv_camera_get_exposure_time_bounds);
  require_within(camera, "a gain", exposure.gain_db, "dB", arv_camera_get_gain_bounds);
  ask(fmt::format("the camera refuses an exposure of {:.0f} us", time_us),
      [&](GError** e) { arv_camera_set_exposure_time(camera, time_us, e); });
  ask(fmt::format("the camera refuses a gain of {} dB", exposure.gain_db),
      [&](GError** e) { arv_camera_set_gain(camera, exposure.gain_db, e); });
}

GObjectPtr<ArvCamera> open_gige(const std::string& address) {
  const GObjectPtr<ArvDevice> device = reach_gige(address);
  take_control(device.get(), address);
  return GObjectPtr<ArvCamera>(
      ask("the GigE camera at " + address + " does not open",
          [&](GError** e) { return arv_camera_new_with_device(device.get(), e); }));
}

GObjectPtr<ArvCamera> open_usb(std::string& serial) {
  for (const char* other : {"GigEVision", "Fake"}) arv_disable_interface(other);
  arv_update_device_list();
  std::string present;
  for (unsigned int i = 0; i < arv_get_n_devices(); ++i) {
    const std::string found = arv_get_device_serial_nbr(i);
    present += (present.empty() ? "" : ", ") + found;
    if (!serial.empty() && found != serial) continue;
    serial = found;
    const char* device = arv_get_device_id(i);
    return GObjectPtr<ArvCamera>(ask("the USB camera " + found + " does not open",
                                     [&](GError** e) { return arv_camera_new(device, e); }));
  }
  throw WorkError({fmt::format("no USB camera{} is plugged in{}",
                               serial.empty() ? "" : " with the serial number " + serial,
                               present.empty() ? "" : " (there are: " + present + ")"),
                   "check the camera's cable and power; lsusb -t shows what is plugged in", "",
                   Cause::kMissing});
}

}  // namespace planar
