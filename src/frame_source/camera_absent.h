#pragma once

#include "core/error.h"

namespace planar {

/// No camera answers where one should.
class CameraAbsent : public WorkError {
 public:
  using WorkError::WorkError;
};

}  // namespace planar
