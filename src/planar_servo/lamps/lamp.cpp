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

}  // namespace planar
