#include "planar_servo/lamps/lamp.h"

#include <stdexcept>

#include "planar_servo/core/error.h"

namespace planar {

const char* name(LampStatus status) {
  switch (status) {
    case LampStatus::kOk:
      return "ok";
    case LampStatus::kNoLamp:
      return "no_lamp";
    case LampStatus::kOneLamp:
      return "one_lamp";
    case LampStatus::kWrongDistance:
      return "wrong_distance";
    case LampStatus::kSaturated:
      return "saturated";
    case LampStatus::kAtBorder:
      return "at_border";
    case LampStatus::kAmbiguous:
      return "ambiguous";
    case LampStatus::kNotRound:
      return "not_round";
    case LampStatus::kLowContrast:
      return "low_contrast";
  }
  throw std::invalid_argument("not a lamp status");
}

const char* name(CenterMethod method) {
  switch (method) {
    case CenterMethod::kAuto:
      return "auto";
    case CenterMethod::kFast:
      return "fast";
    case CenterMethod::kCannyKasa:
      return "canny-kasa";
    case CenterMethod::kVpDot2:
      return "vpdot2";
  }
  throw std::invalid_argument("not a centre method");
}

std::vector<std::string> center_method_names() {
  std::vector<std::string> names;
  for (const CenterMethod method : kCenterMethods) names.emplace_back(name(method));
  return names;
}

CenterMethod center_method_named(const std::string& wanted) {
  std::string allowed;
  for (const CenterMethod method : kCenterMethods) {
    if (wanted == name(method)) return method;
    allowed += (allowed.empty() ? "" : ", ") + std::string(name(method));
  }
  throw InputError("unknown centre method '" + wanted + "'; allowed are " + allowed);
}

}  // namespace planar
