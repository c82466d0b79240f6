#include "lamps/lamp_families.h"

#include "lamps/defective_lamp.h"
#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

constexpr double kGradient = 0.4, kHalo = 0.25, kRim = 0.025, kCut = 0.8;
constexpr double kGradientAmplitude = 160.0;  // keeps the bright side under 255

struct Defects {
  bool gradient{false}, halo{false}, rim{false}, bite{false};

  bool any() const { return gradient || halo || rim || bite; }
};

struct Shape {
  double amplitude{180.0}, axis_ratio{1.0}, diameter_px{40.0};
};

DefectiveLamp draw(const Shape& shape, const Defects& defects, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-0.5, 0.5), blur(0.7, 1.0), turn(0.0, 2.0 * kPi);
  std::uniform_int_distribution<int> kind(0, 2);
  DefectiveLamp lamp;
  lamp.center_px = {0.5 * kWindowSide_px + shift(random), 0.5 * kWindowSide_px + shift(random)};
  lamp.blur_px = blur(random);
  lamp.diameter_px = shape.diameter_px;
  lamp.axis_ratio = shape.axis_ratio;
  lamp.background = kBackground;
  lamp.amplitude = shape.amplitude;
  lamp.direction_rad = turn(random);
  lamp.gradient_direction_rad = turn(random);
  lamp.gradient_kind = static_cast<GradientKind>(kind(random));
  lamp.halo_direction_rad = turn(random);
  lamp.cut_direction_rad = turn(random);
  if (defects.gradient) {
    lamp.gradient = kGradient;
    lamp.amplitude = kGradientAmplitude;
  }
  if (defects.halo) lamp.halo = kHalo;
  if (defects.rim) draw_rim(lamp, kRim, random);
  if (defects.bite) lamp.cut = kCut;
  return lamp;
}

LampFamily family(const std::string& name, const Shape& shape, const Defects& defects) {
  return {name, [shape, defects](std::mt19937& random) {
            const DefectiveLamp lamp = draw(shape, defects, random);
            LampSample sample{render(lamp, {kWindowSide_px, kWindowSide_px}), lamp.center_px,
                              std::nullopt};
            if (!defects.any()) {
              sample.clean = {lamp.center_px,     lamp.diameter_px, lamp.axis_ratio,
                              lamp.direction_rad, lamp.amplitude,   lamp.blur_px};
            }
            return sample;
          }};
}

}  // namespace

std::vector<LampFamily> lamp_families() {
  return {family("clean", {}, {}),
          family("amplitude 60", {60.0}, {}),
          family("amplitude 400", {400.0}, {}),
          family("20 px", {180.0, 1.0, 20.0}, {}),
          family("ellipse 0.8", {180.0, 0.8}, {}),
          family("gradient", {}, {true}),
          family("halo", {}, {false, true}),
          family("irregular", {}, {false, false, true}),
          family("bite", {}, {false, false, false, true}),
          family("all four", {}, {true, true, true, true})};
}

}  // namespace planar::bench
