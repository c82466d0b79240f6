#include "planar_servo/lamps/lamp.h"

namespace planar {

const char* name(LampStatus status) {
  return name_in(kLampStatuses, status);
}

}  // namespace planar
