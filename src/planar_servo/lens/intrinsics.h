#pragma once

namespace planar {

/// Holds focal lengths and principal point in pixels: u = fx x + cx, v = fy y + cy.
struct Intrinsics {
  double fx{1.0}, fy{1.0}, cx{0.0}, cy{0.0};
};

/// The intrinsics of every lens model's sample camera.
inline constexpr Intrinsics kSampleIntrinsics{5200.0, 5190.0, 2570.0, 2540.0};

}  // namespace planar
