#pragma once

#include "planar_servo/core/error.h"

namespace planar {

/// No camera answers where one should.
class CameraAbsent : public WorkError {
 public:
  using WorkError::WorkError;
};

}  // namespace planar
