#pragma once

namespace planar {

/// Focal lengths and principal point in pixels: u = fx x + cx, v = fy y + cy.
struct Intrinsics {
  double fx{1.0}, fy{1.0}, cx{0.0}, cy{0.0};
};

/// Those of every lens model's sample camera.
inline constexpr Intrinsics kSampleIntrinsics{5200.0, 5190.0, 2570.0, 2540.0};

}  // namespace planar
