#pragma once

#include <vector>

#include "planar_servo/lens/camera_model.h"

namespace planar::test {

/// One camera of each lens model, with distortion of the size real lenses have.
inline std::vector<CameraModel> sample_cameras() {
  const Intrinsics k{5200.0, 5190.0, 2570.0, 2540.0};
  return {Pinhole{k},
          VispModel{k, 0.05, -0.047},
          PlumbBob{k, -0.12, 0.05, 4e-4, -3e-4, -0.01},
          Rational{k, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002},
          KannalaBrandt{k, -0.03, 0.006, -0.002, 3e-4},
          OpenCv14{{k, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002},
                   4e-4,
                   -2e-4,
                   -3e-4,
                   1e-4,
                   0.03,
                   -0.02}};
}

}  // namespace planar::test
