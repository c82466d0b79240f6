#pragma once

namespace planar {

// Values are in SI units inside the program. These constants convert at its edges: x_mm = x /
// kMillimetre.
constexpr double kPi = 3.14159265358979323846;
constexpr double kMillimetre = 1e-3;
constexpr double kMicrometre = 1e-6;
constexpr double kInch = 25.4 * kMillimetre;
constexpr double kMillisecond = 1e-3;
constexpr double kMicrosecond = 1e-6;
constexpr double kDegree = kPi / 180.0;
constexpr double kHour = 3600.0;

/// Returns a length (metres) in millimetres.
constexpr double mm(double metres) {
  return metres / kMillimetre;
}

}  // namespace planar
