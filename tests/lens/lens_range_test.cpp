#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/lens/radial_map.h"

namespace planar {
namespace {

constexpr Intrinsics kUnit{1.0, 1.0, 0.0, 0.0};

TEST_CASE("A barrel lens has pixels only up to the radius at which its mapping turns back") {
  const PlumbBob barrel{kUnit, -0.3};
  const double turning_radius = 1.0 / std::sqrt(3.0 * 0.3);
  const double largest_image = turning_radius * (1.0 - 0.3 * turning_radius * turning_radius);
  for (const double phi : {0.0, 0.7, 2.0, 4.0}) {
    const Eigen::Vector2d direction(std::cos(phi), std::sin(phi));
    const auto at = [&](double r) {
      return Eigen::Vector3d(r * direction.x(), r * direction.y(), 1);
    };
    CHECK(project(barrel, at(0.999 * turning_radius)));
    CHECK_FALSE(project(barrel, at(1.001 * turning_radius)));
    CHECK_FALSE(project(barrel, at(5.0 * turning_radius)));
    CHECK(ray(barrel, 0.999 * largest_image * direction));
    CHECK_FALSE(ray(barrel, 1.001 * largest_image * direction));
  }
}

TEST_CASE("Beyond a radius of no growth a lens stays invalid even where it grows again") {
  // r (1 - 0.6 r^2 + 0.13 r^4) shrinks between r = 0.88 and 1.41 and grows again after.
  const PlumbBob folded{kUnit, -0.6, 0.13};
  CHECK(project(folded, {0.8, 0.0, 1.0}));
  CHECK_FALSE(project(folded, {1.5, 0.0, 1.0}));
}

TEST_CASE("A rational lens ends before the pole of its denominator") {
  Rational pole{kUnit};
  pole.k4 = -0.25;
  CHECK(project(pole, {1.9, 0.0, 1.0}));
  CHECK_FALSE(project(pole, {2.1, 0.0, 1.0}));
  CHECK(ray(pole, {10.0, 0.0}));
}

TEST_CASE("A tilted sensor ends where its plane runs parallel to the rays") {
  constexpr double kTilt = 0.5;
  OpenCv14 tilted{{kUnit}};
  tilted.tau_y = kTilt;
  // Rays meet the plane through (0, 0, 1) turned by the tilt from x = -1 / tan(tilt) on.
  const double limit = 1.0 / std::tan(kTilt);
  CHECK(project(tilted, {5.0 * limit, 0.3, 1.0}));
  CHECK(project(tilted, {-0.999 * limit, 0.3, 1.0}));
  CHECK_FALSE(project(tilted, {-1.001 * limit, 0.3, 1.0}));
}

TEST_CASE("An equidistant lens sees nothing at a right angle or beyond") {
  const KannalaBrandt fisheye{kUnit};
  CHECK(ray(fisheye, {1.5, 0.0}));
  CHECK_FALSE(ray(fisheye, {1.58, 0.0}));
}

TEST_CASE("A polynomial is positive up to its first root and not beyond") {
  lens::Polynomial cubic(4);
  cubic << 6.0, -11.0, 6.0, -1.0;  // (1 - s) (2 - s) (3 - s)
  CHECK(lens::positive_up_to(0.0, cubic));
  CHECK(lens::positive_up_to(0.9999, cubic));
  CHECK_FALSE(lens::positive_up_to(1.0001, cubic));
  CHECK_FALSE(lens::positive_up_to(2.5, cubic));
  lens::Polynomial touching(3);
  touching << 1.01, -2.0, 1.0;  // (s - 1)^2 + 0.01
  CHECK(lens::positive_up_to(3.0, touching));
}

}  // namespace
}  // namespace planar
